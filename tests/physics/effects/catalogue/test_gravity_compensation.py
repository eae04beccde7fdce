"""Gravity compensation: what cancels gravity is what MuJoCo's own compensation adds."""

from typing import Any

import mujoco
import numpy as np
import pytest

from estexp_jax.physics.effects.catalogue.gravity_compensation import GravityCompensation
from estexp_jax.physics.effects.changes import Change, encode, stack
from estexp_jax.physics.effects.registry import catalogue
from estexp_jax.physics.effects.sites import ALL_ALIKE
from estexp_jax.physics.engines.choice import open_loop_simulator
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.physics.window import InitialState, window_of

XML = """
<mujoco>
  <option timestep="0.002" integrator="implicitfast" gravity="1 0.5 -9.8"/>
  <default><geom contype="0" conaffinity="0"/></default>
  <worldbody>
    <body pos="0 0 1" quat="0.9 0.3 0 0.2" {0}><joint name="lift" type="slide" axis="0.2 0 1" damping="1"/>
      <geom type="box" size="0.1 0.05 0.05" mass="1"/>
      <body pos="0.1 0 0" {0}><joint name="turn" axis="0 1 0.3" damping="0.05"/>
        <geom type="capsule" size="0.02" fromto="0 0 0 0.3 0 0" mass="0.6"/>
        <body pos="0.3 0 0" {0}><joint name="bend" axis="0 1 0" damping="0.05"/>
          <geom type="capsule" size="0.02" fromto="0 0 0 0.2 0 0.1" mass="0.4"/></body></body></body>
  </worldbody>
  <actuator><motor joint="lift"/><motor joint="turn"/><motor joint="bend"/></actuator>
</mujoco>
"""
SHARE = 0.6
START = np.array([0.1, 0.4, -0.7])


@pytest.mark.parametrize("engine", ["lanes", "mjx", "c"])
def test_it_is_mujocos_own_at_all_joints(engine: str) -> None:
    subject, rows = Robot.from_string(XML.format(""), "arm.xml"), 41
    model = mujoco.MjModel.from_xml_string(XML.format(f'gravcomp="{SHARE}"'))
    data, wanted, time = mujoco.MjData(model), [], 0.01 * np.arange(rows)
    commands = np.stack([9.0 + np.sin(9.0 * time), np.cos(7.0 * time), 0.4 * np.sin(5.0 * time)], axis=1)
    data.qpos[:] = START
    for u in commands:
        wanted.append(data.qpos.copy())
        data.ctrl[:] = u
        mujoco.mj_step(model, data, 5)
    nothing = np.full((rows, 3), np.nan)
    recording = Recording("r", time, commands, np.ones((rows, 3)), nothing, nothing, nothing)
    window = window_of([recording], 0, (0, rows - 1), 0.002, InitialState(START, np.zeros(3)))
    effects = catalogue(["gravity_compensation"])
    sets: list[list[Change]] = [[], [Change("gravity_compensation", ALL_ALIKE, {"share": SHARE})]]
    values = stack([encode(subject, effects, changes) for changes in sets])
    simulator: Any = open_loop_simulator(subject, effects, [subject], engine=engine, width=2)
    without, found = simulator.replay(values, [window], np.zeros(2, int)).qpos
    np.testing.assert_allclose(found, wanted, atol=2e-4)
    assert np.abs(without - found).max() > 0.02


def test_only_driven_joints_that_feel_gravity_have_a_place() -> None:
    flat = Robot.from_string(XML.replace("1 0.5 -9.8", "0 0 0").format(""), "flat.xml")
    assert GravityCompensation().sites(flat) == ()
    arm = Robot.from_string(XML.format("").replace('<motor joint="bend"/>', ""), "arm.xml")
    assert GravityCompensation().sites(arm) == ("lift", "turn", ALL_ALIKE)
