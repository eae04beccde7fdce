"""Growth of a joint fit: effects that a balance of torques cannot size are found on the readings, and junk goes."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace
from functools import cache
from typing import Any

import mujoco
import numpy as np

from estexp_jax.discovery.diagnosis import Case, ExplainConfig
from estexp_jax.discovery.joint.fit import JointSearch
from estexp_jax.discovery.joint.growth import Growth
from estexp_jax.discovery.joint.held_out import HeldOutGain
from estexp_jax.discovery.joint.proposals import Proposal
from estexp_jax.discovery.joint.reading_stage import JointFit
from estexp_jax.discovery.joint.strategy import joint_problem_of
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording

_XML = """<mujoco><option timestep="0.004" integrator="implicitfast"><flag contact="disable"/></option><worldbody>
<body name="rod"><joint name="pivot" axis="0 1 0" armature="0.002"/><geom type="capsule" size="0.02" mass="0.5"
 fromto="0 0 0 0 0 -0.4"/></body></worldbody><actuator><motor name="motor" joint="pivot"/></actuator>
<sensor><jointpos name="angle" joint="pivot"/></sensor></mujoco>"""
_WEAKER, _DAMPING = 0.3, 0.03


def _recorded(name: str, role: str, seed: int) -> Recording:
    """A pendulum whose motor is weaker by 30 % and whose pivot is damped, at a tenth of the step."""
    real = mujoco.MjModel.from_xml_string(_XML)
    real.opt.timestep /= 10.0
    real.dof_damping[:], real.actuator_gainprm[:, 0] = _DAMPING, 1.0 - _WEAKER
    rng, data, rows = np.random.default_rng(seed), mujoco.MjData(real), 1200
    rate, phase = rng.uniform(0.2, 1.5, 4), rng.uniform(0.0, 6.0, 4)
    time = np.arange(rows) / 100.0
    ctrl = 0.5 * np.sin(2.0 * np.pi * rate * time[:, None] + phase).sum(axis=1, keepdims=True)
    sensor = np.zeros((rows, 1))
    for k in range(rows):
        sensor[k] = data.qpos + 3e-4 * rng.standard_normal(1)
        data.ctrl[:] = ctrl[k]
        mujoco.mj_step(real, data, 25)
    nothing = np.full((rows, 1), np.nan)
    return Recording(name, time, ctrl, np.ones((rows, 1)), sensor, nothing, nothing.copy(), role=role)


@cache
def _case() -> Case:
    robot = Robot.from_string(_XML, "rod")
    made = (_recorded("a.csv", "train", 1), _recorded("b.csv", "train", 2), _recorded("c.csv", "test", 3))
    return Case(robot, made, (robot,) * 3)


def _result(steps: Generator[Any, None, Any]) -> Any:
    try:
        while True:
            next(steps)
    except StopIteration as end:
        return end.value


def test_a_weak_motor_is_found_beside_a_damped_joint():
    _, problem = joint_problem_of(_case(), replace(ExplainConfig(), engine="c"), {})
    search = JointSearch(problem)
    found = search.settled(_result(search.grown(_result(search.first()).fit)))
    assert set(found.places) == {("motor_weakness", "motor"), ("viscous_friction", "pivot")}


def test_a_replacement_far_beyond_its_bounds_is_fitted_from_within_them(monkeypatch):
    _, problem = joint_problem_of(_case(), replace(ExplainConfig(), engine="c"), {})
    search, none, begun = JointSearch(problem), np.zeros(0), []
    monkeypatch.setattr(Growth, "_step", lambda self, point, places, prune: begun.append(point))
    fit = JointFit(search.space.neutral, (), none.astype(int), none[None, :0], none, {}, 1.0, np.ones(1))
    growth = search._growth(search._windows(search.space.neutral, 1), fit)
    mass = next(c for c in search._candidates() if c.place == ("body_mass", "rod"))
    index = int(np.flatnonzero(mass.direction)[0])
    gain = HeldOutGain(0.0, 1.0, -1e3 / mass.direction[index], 1)  # far below nothing: no simulator takes that
    growth._fitted(fit, [Proposal(mass, None, gain, 0.0)])
    assert begun[0][index] == search.space.bounds[index, 0]
