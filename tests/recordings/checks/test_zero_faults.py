"""Positions whose zero is elsewhere; those of robots as they should be, under gravity and at their stops, are not."""

from dataclasses import replace

import numpy as np
import pytest

from estexp_jax.physics.model.robot import Robot
from estexp_jax.recordings.checks.inspect import judge
from estexp_jax.recordings.checks.zero_faults import limit_faults
from tests.estimation.two_links import XML, arm, log_of

SERVOS = {"motor": "position", "gain": 'kp="20" kv=".5"', "friction": 0.0, "mass": 0.4, "damping": 0.2}


def limited() -> Robot:
    text = XML.format(**SERVOS).replace("<joint axis", '<joint limited="true" range="-1.8 1.8" axis')
    return Robot.from_string(text)


def kinds(robot, recording, column="sensor.q_elbow"):
    found = judge(robot, recording, replayed=False)["faults"]
    return {fault["kind"]: fault["sentence"] for fault in found if fault["name"] == column}


def displaced(by: float):
    log = log_of(arm())
    return replace(log, sensor=log.sensor + np.array([0.0, by]))


def test_an_arm_that_gravity_pulls_down_has_none():
    assert not {"offset", "beyond_limits"} & set(kinds(limited(), log_of(limited())))
    assert not {"offset", "beyond_limits"} & set(kinds(arm(), log_of(arm(mass=0.8))))


@pytest.mark.parametrize("by", [0.3, -0.4])
def test_an_offset_is_told_with_its_size(by):
    told = kinds(arm(), displaced(by))["offset"]
    size = float(told.partition("give offset = ")[2])
    assert abs(size + by) < 0.1 and "beside its command" in told


@pytest.mark.parametrize("turns", [1, -2])
def test_whole_turns_are_told_as_such(turns):
    told = kinds(arm(), displaced(2.0 * np.pi * turns))["offset"]
    assert "whole turn" in told and f"give offset = {-2.0 * np.pi * turns:.6g}" in told
    told = kinds(limited(), displaced(2.0 * np.pi * turns))["beyond_limits"]
    assert "whole turn" in told and f"give offset = {-2.0 * np.pi * turns:.6g}" in told


def test_what_a_joint_cannot_reach_is_told_and_a_stop_that_gives_is_not():
    [fault] = limit_faults(limited(), 1, "sensor.q_elbow", np.linspace(-2.5, 1.0, 100))
    assert "limits of -1.8 to 1.8" in fault.sentence and "up to -2.5" in fault.sentence
    assert not [*limit_faults(limited(), 1, "sensor.q_elbow", np.linspace(-1.85, 1.9, 100))]
    assert not [*limit_faults(arm(), 1, "sensor.q_elbow", np.linspace(-9.0, 9.0, 100))]
