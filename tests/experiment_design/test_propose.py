"""Proposed motions tell rivals apart as far as limits allow, and say so where none does."""

import json
from dataclasses import replace
from unittest.mock import patch

import mujoco
import numpy as np
import pytest

from estexp_jax.discovery.contest import Contest, Rival
from estexp_jax.experiment_design import propose as module
from estexp_jax.experiment_design.predictive_simulation import PredictiveSimulation, predictive_simulation_of
from estexp_jax.experiment_design.propose import PLAIN, ProposeConfig, ProposedExperiment, search_experiment
from estexp_jax.experiment_design.separation import (
    limits_of,
    pairwise_separation,
    pairwise_separation_sensitive,
    separation_score,
)
from estexp_jax.package_data import model_path
from estexp_jax.physics.effects.changes import Change, encode, stack
from estexp_jax.physics.model.robot import Robot
from estexp_jax.report.propose.text import propose_rows, propose_verdict, rival_status
from estexp_jax.runs.files import json_plain
from tests.discovery.planted import CASES, Plant, case_of, finished, nominal, problem_of, record, shared_replayer

SMALL = ProposeConfig(duration=3.0, population=24, generations=8)
PAYLOAD = Change("body_mass", "arm", {"dm": 0.15})
WEAK = Change("motor_weakness", "servo", {"loss": 0.15 / 0.65})
"""A tired motor that holds the arm just as a strong one holds the arm with a payload."""
DRY = Change("coulomb_friction", "shaft", {"T": 0.1})
VISCOUS = Change("viscous_friction", "shaft", {"c": 0.08})
BACK_EMF = Change("back_emf", "servo", {"k": 0.08})


def contest(*changes: Change, probabilities: tuple[float, ...] | None = None, speed: float = 0.0) -> Contest:
    shares = probabilities or (1.0 / len(changes),) * len(changes)
    rivals = tuple(Rival((c,), (c,), p, 1.0) for c, p in zip(changes, shares, strict=True))
    files = (("a.csv", "train"), ("b.csv", "test"))
    return Contest(rivals, ("angle",), np.array([5e-4]), 100.0, np.array([[-1.6, 1.6]]), np.array([speed]), files)


def proposed(among: Contest, config: ProposeConfig = SMALL) -> ProposedExperiment:
    with patch.object(module, "replayer", lambda *_, **__: shared_replayer("one")):
        return finished(search_experiment(nominal("one"), among, 4, config))


def rehearsal(among: Contest) -> PredictiveSimulation:
    return predictive_simulation_of(shared_replayer("one"), among).finer(4)


def apart(among: Contest, time: np.ndarray, commands: np.ndarray) -> float:
    limits = limits_of(nominal("one"), 0.9, among.commands, np.array([np.inf]))
    [shown] = rehearsal(among).shown(time, [commands], limits)
    return float(shown.apart[0, 1])


def test_what_only_more_numbers_make_improbable_is_worth_a_motion_and_no_refuted_rival():
    among = contest(PAYLOAD, WEAK, probabilities=(1.0, 0.0))
    as_good = replace(among, rivals=(among.rivals[0], replace(among.rivals[1], tied=True)))
    assert rehearsal(among).probabilities.tolist() == [1.0, 0.0]
    assert rehearsal(as_good).probabilities.tolist() == [1.0, 0.1]
    assert [rival_status(c.rivals[1]) for c in (among, as_good)] == ["refuted already", "fits as well, by more numbers"]
    assert Rival.from_json(as_good.rivals[1].to_json()).tied


def test_a_joint_that_was_held_may_move_as_fast_as_its_motor_allows():
    moved = contest(PAYLOAD, WEAK, speed=0.1)
    held = replace(moved, commands=np.zeros((1, 2)))
    fastest = [np.abs(np.diff(proposed(c).shown.readings[:, :, 0], axis=1)).max() * 100.0 for c in (moved, held)]
    assert fastest[0] < 0.5 < fastest[1]


def test_no_motion_may_bring_parts_together_that_the_simulation_lets_through_each_other():
    among, spec = contest(PAYLOAD, WEAK), nominal("one").spec.copy()
    spec.worldbody.add_geom(name="wall", type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.02, 0.5, 0.5], pos=[-0.2, 0, 0])
    walled = predictive_simulation_of(shared_replayer("one"), among, Robot.from_spec(spec), [(0, 1)])
    limits, time = limits_of(nominal("one"), 0.9, among.commands, np.array([np.inf])), np.arange(150) / 100.0
    away, at = (np.full((150, 1), angle) for angle in (-1.0, 1.0))
    assert [shown.excess > 1.0 for shown in walled.shown(time, [away, at], limits)] == [False, True]
    assert all(shown.excess <= 0.0 for shown in rehearsal(among).shown(time, [away, at], limits))


@pytest.mark.parametrize("pair", [(PAYLOAD, WEAK), (DRY, VISCOUS)], ids=["payload or weakness", "dry or viscous"])
def test_a_proposed_motion_tells_more_than_what_was_recorded_or_random_ones(pair):
    among = contest(*pair)
    found = proposed(among)
    recorded = record("one", Plant(), 5, role="train", length=3.0)
    best = found.shown.apart[0, 1]
    assert best > 1.15 * apart(among, recorded.time, recorded.ctrl)
    assert best > 1.25 * found.usual[0, 1]
    assert best == pytest.approx(apart(among, found.time, found.commands), rel=1e-3)
    assert best > PLAIN and "tells them apart" in propose_verdict(found)
    assert found.robot_steps > 10_000


def test_what_no_motion_tells_apart_is_said_to_be_so():
    found = proposed(contest(VISCOUS, BACK_EMF))  # the same as long as the motor is on
    assert found.shown.apart[0, 1] < 0.1
    assert propose_verdict(found).startswith("No motion found") and "Still record it" not in propose_verdict(found)
    assert [row["told_apart"] for row in propose_rows(found)] == [False]


def test_of_three_the_two_that_are_alike_do_not_hide_the_third():
    found = proposed(contest(VISCOUS, BACK_EMF, DRY))
    assert found.shown.apart[0, 1] < 0.1 and min(found.shown.apart[0, 2], found.shown.apart[1, 2]) > 10.0
    assert min(found.shown.apart[0, 2] / found.usual[0, 2], found.shown.apart[1, 2] / found.usual[1, 2]) > 1.1
    assert "2 of 3 pairs" in propose_verdict(found) and "1 and 2" in propose_verdict(found)


def test_the_same_seed_finds_the_same_and_another_one_another():
    one, same, other = (proposed(contest(DRY, VISCOUS), replace(SMALL, seed=s)) for s in (1, 1, 2))
    np.testing.assert_array_equal(one.commands, same.commands)
    assert np.abs(one.commands - other.commands).max() > 0.05


def test_a_floating_base_may_move_faster_than_a_robot_that_stood():
    robot, moved = Robot.from_xml(model_path("quadruped")), np.tile([-0.1, 0.1], (8, 1))
    standing = replace(contest(DRY, VISCOUS), commands=moved)
    np.testing.assert_array_equal(module._unlimited(robot, standing), [True] * 6 + [False] * 8)


def test_motions_begin_at_home_and_keep_to_limits_of_speed_and_command():
    limit = 1.2
    slow = proposed(contest(DRY, VISCOUS, speed=limit), replace(SMALL, speed=1.0, margin=0.5))
    assert slow.shown.excess == 0.0
    assert np.abs(np.diff(slow.shown.readings[:, :, 0], axis=1)).max() * 100.0 <= limit
    fast = proposed(contest(DRY, VISCOUS))
    assert np.abs(np.diff(fast.shown.readings[:, :, 0], axis=1)).max() * 100.0 > limit  # so it was the limit
    for found in (slow, fast):
        assert np.abs(found.commands).max() <= 1.6
        np.testing.assert_array_equal(found.commands[:50], 0.0)


def test_commands_go_as_far_as_their_own_range_lets_them():
    body = '<body><joint name="shaft"/><geom size=".1"/></body>'
    arm = f'<mujoco><worldbody>{body}</worldbody><actuator><position joint="shaft" kp="5" {{}}/></actuator></mujoco>'
    none = np.zeros((1, 2))
    for own, low, high in (('ctrlrange="-1.6 1.6"', -1.44, 1.44), ('ctrlrange="-1 3"', -0.8, 0.9), ("", -0.54, 0.54)):
        robot = Robot.from_string(arm.format(own))
        limits = limits_of(robot, 0.9, none, np.array([np.inf]))
        assert (limits.low, limits.high) == pytest.approx((low, high)), own


def test_joint_ranges_are_kept_under_every_rival():
    limits = limits_of(nominal("one"), 0.9, np.array([[-1.0, 1.0]]), np.array([np.inf]))
    ranged = replace(limits, places=np.array([0]), lowest=np.array([-0.5]), highest=np.array([0.5]))
    qpos = np.array([[[0.1], [0.4]], [[0.0], [0.6]]])
    assert ranged.excess(qpos, 0.0 * qpos) == pytest.approx(0.2)
    assert ranged.excess(qpos[:1], 0.0 * qpos) == 0.0


def test_a_simulation_that_blows_up_is_never_proposed():
    wild = contest(DRY, Change("armature", "shaft", {"I": -0.02}))  # more than the arm's own inertia
    time = np.arange(301) / 100.0
    limits = limits_of(nominal("one"), 0.9, wild.commands, np.array([np.inf]))
    [shown] = rehearsal(wild).shown(time, [np.sin(time)[:, None]], limits)
    assert np.isnan(shown.apart).all()
    assert module._cost(shown, rehearsal(wild)) == np.inf


def test_separation_leaves_out_what_ordinary_errors_explain():
    draw = np.random.default_rng(3)
    readings, directions = draw.normal(size=(3, 40, 2)), 5.0 * draw.normal(size=(4, 40, 2))
    found = pairwise_separation(readings, directions)
    assert pairwise_separation(readings, directions[:0])[0, 1] == pytest.approx(
        np.sqrt(np.sum((readings[0] - readings[1]) ** 2) / 40)
    )
    for i, j in ((0, 1), (1, 2), (0, 2)):  # the same by least squares, with the errors' price as further samples
        design = np.concatenate([directions.reshape(4, -1).T / np.sqrt(40), np.eye(4)])
        aim = np.concatenate([(readings[i] - readings[j]).ravel() / np.sqrt(40), np.zeros(4)])
        left = aim - design @ np.linalg.lstsq(design, aim, rcond=None)[0]
        assert found[i, j] == pytest.approx(np.linalg.norm(left))
    along = np.stack([0.0 * directions[0], 2.0 * directions[0]])
    assert pairwise_separation(along, directions[:1])[0, 1] == pytest.approx(2.0, rel=0.02)


def test_where_robots_part_for_good_errors_count_as_noise():
    readings, directions = np.zeros((2, 4, 1)), np.zeros((1, 4, 1))
    readings[1, :, 0], directions[0, :, 0] = 6.0, (0.0, 0.0, np.sqrt(3.0), np.sqrt(3.0))
    assert pairwise_separation_sensitive(readings, directions)[0, 1] == pytest.approx(
        6.0 * np.sqrt((2.0 + 2.0 / 4.0) / 4.0)
    )


def test_probable_rivals_count_more():
    first, second = np.zeros((3, 3)), np.zeros((3, 3))
    first[0, 1] = first[1, 0] = second[0, 2] = second[2, 0] = 5.0
    shares = np.array([0.6, 0.35, 0.05])
    assert separation_score(first, shares) > separation_score(second, shares) > separation_score(0.0 * first, shares)


def test_rivals_of_an_explanation_come_back_and_simulate_as_explained(diagnosed):
    diagnosis = diagnosed("coulomb_friction@shaft")
    found = Contest.from_json(json.loads(json.dumps(json_plain(diagnosis.contest.to_json(), "contest"))))
    assert [r.changes for r in found.rivals] == [r.changes for r in diagnosis.contest.rivals]
    assert found.rivals[0].label == "coulomb_friction@shaft" and len(found.rivals) >= 3
    assert len({r.label for r in found.rivals}) == len(found.rivals)
    problem = problem_of(diagnosis.case)
    index = diagnosis.case.indices("test")[0]
    windows, step = problem.windows_of([index]), nominal("one").model.opt.timestep / diagnosis.rivals_finer
    fine = [s.stepped(step) for s in problem.segments]
    values = encode(nominal("one"), problem.replayer.catalogue, found.rivals[0].changes)
    replay = problem.replayer.replay(stack([values] * len(windows)), fine, windows)
    simulated = np.concatenate([replay.sensors[k, : fine[w].rows, 0] for k, w in enumerate(windows)])
    np.testing.assert_allclose(simulated, diagnosis.predictions[index].explained[:, 0], atol=1e-5)
    assert 0.0 < found.deviations[0] < 0.01 and found.rate == pytest.approx(100.0)


def test_agreement_leaves_no_rivals(diagnosed):
    assert len(diagnosed("nothing").contest.rivals) == 1


def test_a_rival_found_in_recordings_is_told_apart(diagnosed):
    found = proposed(diagnosed("coulomb_friction@shaft").contest)
    robot, plant, _ = CASES["coulomb_friction@shaft"]
    usual = case_of(robot, plant, 7).recordings[0]
    limits = limits_of(nominal("one"), 0.9, found.contest.commands, np.array([np.inf]))
    ready = rehearsal(found.contest)
    [recorded] = ready.shown(usual.time, [usual.ctrl], limits)
    assert separation_score(found.shown.apart, ready.probabilities) > separation_score(
        recorded.apart, ready.probabilities
    )
