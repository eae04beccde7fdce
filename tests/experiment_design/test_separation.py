"""Separations, limits and motions."""

from dataclasses import replace

import numpy as np
import pytest

from estexp_jax.experiment_design.separation import (
    limits_of,
    pairwise_separation,
    pairwise_separation_sensitive,
    separation_score,
)
from estexp_jax.physics.model.robot import Robot
from tests.discovery.planted import nominal


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
    ranged = replace(limits, qpos_addresses=np.array([0]), lowest=np.array([-0.5]), highest=np.array([0.5]))
    qpos = np.array([[[0.1], [0.4]], [[0.0], [0.6]]])
    assert ranged.excess(qpos, 0.0 * qpos) == pytest.approx(0.2)
    assert ranged.excess(qpos[:1], 0.0 * qpos) == 0.0


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
