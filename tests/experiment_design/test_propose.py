"""Proposed motions tell rivals apart as far as limits allow, and say so where none does."""

from dataclasses import replace

import numpy as np
import pytest

from estexp_jax.experiment_design import propose as module
from estexp_jax.experiment_design.propose import CLEAR_SEPARATION
from estexp_jax.experiment_design.separation import limits_of, separation_score
from estexp_jax.package_data import model_path
from estexp_jax.physics.model.robot import Robot
from estexp_jax.report.propose.text import propose_rows, propose_verdict
from tests.discovery.planted import CASES, Plant, case_of, nominal, record
from tests.experiment_design.competing import (
    BACK_EMF,
    DRY,
    PAYLOAD,
    SMALL,
    VISCOUS,
    WEAK,
    competing,
    proposed,
    separation_of,
    simulation,
)


def test_a_joint_that_was_held_may_move_as_fast_as_its_motor_allows():
    moved = competing(PAYLOAD, WEAK, speed=0.1)
    held = replace(moved, commands=np.zeros((1, 2)))
    fastest = [np.abs(np.diff(proposed(c).predicted.readings[:, :, 0], axis=1)).max() * 100.0 for c in (moved, held)]
    assert fastest[0] < 0.5 < fastest[1]


@pytest.mark.parametrize("pair", [(PAYLOAD, WEAK), (DRY, VISCOUS)], ids=["payload or weakness", "dry or viscous"])
def test_a_proposed_motion_tells_more_than_what_was_recorded_or_random_ones(pair):
    among = competing(*pair)
    found = proposed(among)
    recorded = record("one", Plant(), 5, role="train", length=3.0)
    best = found.predicted.separation[0, 1]
    assert best > 1.15 * separation_of(among, recorded.time, recorded.ctrl)
    assert best > 1.25 * found.random_separation[0, 1]
    assert best == pytest.approx(separation_of(among, found.time, found.commands), rel=1e-3)
    assert best > CLEAR_SEPARATION and "tells them apart" in propose_verdict(found)
    assert found.robot_steps > 10_000


def test_what_no_motion_tells_apart_is_said_to_be_so():
    found = proposed(competing(VISCOUS, BACK_EMF))  # the same as long as the motor is on
    assert found.predicted.separation[0, 1] < 0.1
    assert propose_verdict(found).startswith("No motion found") and "Still record it" not in propose_verdict(found)
    assert [row["told_apart"] for row in propose_rows(found)] == [False]


def test_of_three_the_two_that_are_alike_do_not_hide_the_third():
    found = proposed(competing(VISCOUS, BACK_EMF, DRY))
    separation = found.predicted.separation
    assert separation[0, 1] < 0.1 and separation[:2, 2].min() > 10.0
    assert (separation[:2, 2] / found.random_separation[:2, 2]).min() > 1.1
    assert "2 of 3 pairs" in propose_verdict(found) and "1 and 2" in propose_verdict(found)


def test_the_same_seed_finds_the_same_and_another_one_another():
    one, same, other = (proposed(competing(DRY, VISCOUS), replace(SMALL, seed=s)) for s in (1, 1, 2))
    np.testing.assert_array_equal(one.commands, same.commands)
    assert np.abs(one.commands - other.commands).max() > 0.05


def test_a_floating_base_may_move_faster_than_a_robot_that_stood():
    robot, moved = Robot.from_xml(model_path("quadruped")), np.tile([-0.1, 0.1], (8, 1))
    standing = replace(competing(DRY, VISCOUS), commands=moved)
    np.testing.assert_array_equal(module._unlimited(robot, standing), [True] * 6 + [False] * 8)


def test_motions_begin_at_home_and_keep_to_limits_of_speed_and_command():
    limit = 1.2
    slow = proposed(competing(DRY, VISCOUS, speed=limit), replace(SMALL, speed=1.0, margin=0.5))
    assert slow.predicted.excess == 0.0
    assert np.abs(np.diff(slow.predicted.readings[:, :, 0], axis=1)).max() * 100.0 <= limit
    fast = proposed(competing(DRY, VISCOUS))
    assert np.abs(np.diff(fast.predicted.readings[:, :, 0], axis=1)).max() * 100.0 > limit  # so it was the limit
    for found in (slow, fast):
        assert np.abs(found.commands).max() <= 1.6
        np.testing.assert_array_equal(found.commands[:50], 0.0)


def test_agreement_leaves_no_rivals(diagnosed):
    assert len(diagnosed("nothing").competing_models.models) == 1


def test_a_rival_found_in_recordings_is_told_apart(diagnosed):
    found = proposed(diagnosed("coulomb_friction@shaft").competing_models)
    robot, plant, _ = CASES["coulomb_friction@shaft"]
    usual = case_of(robot, plant, 7).recordings[0]
    limits = limits_of(nominal("one"), 0.9, found.competing_models.commands, np.array([np.inf]))
    ready = simulation(found.competing_models)
    [recorded] = ready.predict(usual.time, [usual.ctrl], limits)
    assert separation_score(found.predicted.separation, ready.probabilities) > separation_score(
        recorded.separation, ready.probabilities
    )
