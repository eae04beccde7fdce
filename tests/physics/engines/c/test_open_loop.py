"""Open loops on the C engine: what plain MuJoCo does to the last digit, and each effect as in MJX."""

import warnings
from copy import copy
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from estexp_jax.physics.effects.base import Effect
from estexp_jax.physics.effects.changes import Change, encode, stack
from estexp_jax.physics.effects.registry import catalogue, every
from estexp_jax.physics.engines.choice import open_loop_simulator
from estexp_jax.physics.engines.open_loop import OpenLoopRollout
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.physics.window import InitialState, Window, window_of
from estexp_jax.recordings.settings import apply_settings
from estexp_jax.runs import count_compilations
from tests.physics.mixed_actuators import MIXED
from tests.versions import needs_mujoco_4

# What lanes refuse, and some of what MJX passes over: a ball joint, tendons that yield, a mimic joint, a group that is
# switched off, a joint's and a tendon's force range, delays, an integrator that derives forces by speed.
ZOO = """
<mujoco model="zoo">
  <compiler angle="radian" autolimits="true"/>
  <option timestep="0.002" integrator="implicitfast" actuatorgroupdisable="2"/>
  <worldbody>
    <geom name="floor" type="plane" size="2 2 .1" pos="0 0 .605"/>
    <body name="neck" pos="0 0 1">
      <joint name="neck" type="ball" damping="0.3"/>
      <geom type="capsule" fromto="0 0 0 0 0 -0.2" size="0.03" mass="1" contype="0" conaffinity="0"/>
      <site name="imu" pos="0 0 -0.1"/>
      <body name="left" pos="0.04 0 -0.2">
        <joint name="left" axis="0 1 0" damping="0.05" armature="0.001" actuatorfrcrange="-0.6 0.6"/>
        <geom type="capsule" fromto="0 0 0 0 0 -0.15" size="0.02" mass="0.2"/>
      </body>
      <body name="right" pos="-0.04 0 -0.2">
        <joint name="right" axis="0 1 0" damping="0.05"/>
        <geom type="capsule" fromto="0 0 0 0 0 -0.15" size="0.02" mass="0.2"/>
      </body>
    </body>
  </worldbody>
  <contact><exclude body1="left" body2="right"/></contact>
  <tendon><fixed name="both" springlength="0.1" stiffness="0.5"><joint joint="left" coef="1"/><joint joint="right" coef="-2"/></fixed></tendon>
  <equality><joint joint1="left" joint2="right" polycoef="0 -1 0 0 0"/></equality>
  <actuator>
    <position name="grip" joint="left" kp="20" kv="1"/>
    <motor name="roll" joint="neck" gear="0.5 0 0"/>
    <position name="pull" tendon="both" kp="2" kv="0.1" forcerange="-0.3 0.3"/>
    <motor name="idle" joint="right" group="1"/>
  </actuator>
  <sensor>
    <jointpos name="angle" joint="left"/><ballquat name="pose" joint="neck"/><gyro name="gyro" site="imu"/>
    <accelerometer name="acc" site="imu"/><actuatorfrc name="force" actuator="grip"/><tendonpos name="length" tendon="both"/>
  </sensor>
</mujoco>
"""  # noqa: E501
SMALL = """
<mujoco model="small">
  <compiler angle="radian" autolimits="true"/>
  <option timestep="0.0025" integrator="implicitfast"/>
  <worldbody>
    <geom name="floor" type="plane" size="2 2 .1" pos="0 0 .605"/>
    <body name="arm" pos="0 0 1">
      <joint name="shoulder" axis="0 1 0" damping="0.05" armature="0.004"/>
      <geom type="capsule" fromto="0 0 0 0 0 -0.25" size="0.02" mass="0.6" contype="0" conaffinity="0"/>
      <body name="hand" pos="0 0 -0.25">
        <joint name="elbow" axis="0 1 0" damping="0.02" armature="0.002" range="-2 2"/>
        <geom type="capsule" fromto="0 0 0 0 0 -0.1" size="0.02" mass="0.2" contype="0" conaffinity="0"/>
        <geom type="sphere" size=".05" pos="0 0 -.1" mass=".05"/><site name="tip" pos="0 0 -.1"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position name="servo" joint="shoulder" kp="12" kv="0.3" forcerange="-4 4"/>
    <motor name="push" joint="elbow" gear="0.5" ctrlrange="-1 1"/>
  </actuator>
  <sensor>
    <jointpos name="a" joint="shoulder"/><jointvel name="b" joint="elbow"/><actuatorfrc name="f" actuator="servo"/>
    <jointactuatorfrc name="g" joint="elbow"/><accelerometer name="acc" site="tip"/>
  </sensor>
</mujoco>
"""
BOX = """
<mujoco><worldbody>
  <geom type="plane" size="1 1 1"/>
  <body name="box" pos="0 0 0.12"><freejoint/><geom type="box" size=".1 .1 .1" mass="1"/></body>
</worldbody></mujoco>
"""
ROWS = 41
ZEROED = catalogue(["viscous_friction"])


def recorded(robot: Robot, *, off: bool = False) -> Recording:
    """A recording at 100 Hz; with the second motor off for a while."""
    model, time = robot.model, 0.01 * np.arange(ROWS)
    ctrl = np.stack([0.9 * np.sin((9.0 - 2.0 * k) * time + k) for k in range(model.nu)], axis=1)
    on = np.ones((ROWS, model.nactuator))
    on[ROWS // 3 : ROWS // 2, 1] = 1.0 - off
    sensor, qpos, qvel = (np.full((ROWS, n), np.nan) for n in (model.nsensordata, model.nq, model.nv))
    return Recording("r.csv", time, ctrl, on, sensor, qpos, qvel)


def window(robot: Robot, recordings: list[Recording], index: int = 0) -> Window:
    start = InitialState(robot.home(), np.zeros(robot.model.nv))
    return window_of(recordings, index, (0, ROWS - 1), float(robot.model.opt.timestep), start)


def plain(model: mujoco.MjModel, qpos: np.ndarray, part: Window) -> tuple[np.ndarray, np.ndarray]:
    """Readings and configurations at rows of a loop over `mj_step`; accelerations as under the command before."""
    data, steps, gain, bias = (
        mujoco.MjData(model),
        part.steps,
        model.actuator_gainprm.copy(),
        model.actuator_biasprm.copy(),
    )
    data.qpos[:] = qpos
    before = np.repeat(model.sensor_needstage == mujoco.mjtStage.mjSTAGE_ACC, model.sensor_dim)
    readings, places = [], []
    for k in range(steps.n_steps + 1):
        now = min(k, steps.n_steps - 1)
        model.opt.timestep, on = steps.length[now], part.enable[steps.row[now]][:, None]
        data.ctrl[:] = part.logged[max(now - (k in steps.sample and k < steps.n_steps), 0)]
        if k in steps.sample:
            warmstart = data.qacc_warmstart.copy()
            mujoco.mj_forward(model, data)
            data.qacc_warmstart[:] = warmstart
        last, place = data.sensordata.copy(), data.qpos.copy()
        data.ctrl[:] = part.logged[now]
        model.actuator_gainprm[:], model.actuator_biasprm[:] = gain * on, bias * on
        mujoco.mj_step(model, data)
        if k in steps.sample:
            readings.append(np.where(before, last, data.sensordata))
            places.append(place)
    return np.array(readings), np.array(places)


def test_a_robot_that_other_engines_refuse_moves_as_in_plain_mujoco() -> None:
    robot = Robot.from_string(ZOO, "zoo.xml")
    part = window(robot, [recorded(robot, off=True)])
    simulator = open_loop_simulator(robot, ZEROED, [robot])
    assert simulator.choice.engine == "c" and "equality constraint" in simulator.choice.reason
    replay = simulator.replay(stack([encode(robot, ZEROED, [])]), [part], np.zeros(1, int))
    readings, places = plain(robot.spec.copy().compile(), robot.home(), part)
    np.testing.assert_allclose(replay.qpos[0], places, rtol=0, atol=1e-12)
    np.testing.assert_allclose(replay.sensors[0, 1:], readings[1:], rtol=1e-10, atol=1e-10)
    assert np.abs(places - places[0]).max() > 0.1 and simulator.left_out == ()


@needs_mujoco_4
def test_actuators_with_several_inputs_or_none_move_as_in_plain_mujoco_and_can_be_switched_off() -> None:
    robot = Robot.from_string(MIXED, "mixed.xml")
    log = recorded(robot)
    on = np.ones((ROWS, robot.model.nactuator))
    on[ROWS // 3 : ROWS // 2, :4] = 0.0
    log = replace(log, enable=on, ctrl=0.5 * log.ctrl)
    part = window(robot, [log])
    simulator = open_loop_simulator(robot, ZEROED, [robot])
    assert simulator.choice.engine == "c" and simulator.choice.largest_difference == pytest.approx(0.0, abs=1e-12)
    replay = simulator.replay(stack([encode(robot, ZEROED, [])]), [part], np.zeros(1, int))
    model, data, places = copy(robot.model), mujoco.MjData(robot.model), []
    for k in range(ROWS):
        places.append(data.qpos.copy())
        model.actuator_forcelimited[:], model.actuator_forcerange[:] = robot.model.actuator_forcelimited, 0.0
        model.actuator_forcelimited[on[k] == 0.0] = 1
        data.ctrl[:] = log.ctrl[k]
        steps = int(np.diff(part.steps.sample)[min(k, ROWS - 2)])
        model.opt.timestep = 0.01 / steps
        mujoco.mj_step(model, data, steps)
    np.testing.assert_allclose(replay.qpos[0], places, rtol=0, atol=1e-9)
    assert np.ptp(places, axis=0).max() > 0.1


def test_settings_of_recordings_and_edits_are_those_of_recompiled_models() -> None:
    robot = Robot.from_string(ZOO, "zoo.xml")
    settings: list[dict[str, Any]] = [
        {},
        {"body.left.mass": 0.5},
        {"actuator.grip.kp": 5.0, "option.gravity": (0.0, 0.0, -4.0)},
    ]
    robots = [apply_settings(robot, own) for own in settings]
    effects = catalogue(["body_mass", "viscous_friction", "coulomb_friction"])
    changes = [Change("body_mass", "right", {"dm": 0.3}), Change("coulomb_friction", "left", {"T": 0.05})]
    recordings = [recorded(robot)] * 3
    parts = [window(robot, recordings, k) for k in range(3)]
    values = stack([encode(robot, effects, own) for own in ([], changes) for _ in range(3)])
    replay = open_loop_simulator(robot, effects, robots, engine="c").replay(values, parts, np.arange(6) % 3)
    for lane in range(6):
        spec = robots[lane % 3].spec.copy()
        for change in changes if lane >= 3 else ():
            [e] = catalogue([change.effect])
            e.write_mjcf(robots[lane % 3], spec, change.name or "", dict(change.parameters))
        model = spec.compile()
        _, places = plain(model, robot.home(), parts[lane % 3])
        np.testing.assert_allclose(replay.qpos[lane], places, rtol=0, atol=1e-6)  # values are in single precision
    apart = [np.abs(replay.qpos[i] - replay.qpos[j]).max() for i in range(6) for j in range(i)]
    assert min(apart) > 1e-3


def test_lanes_that_blow_up_are_nan_from_then_on_and_nothing_is_printed(
    capfd: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    robot = Robot.from_string(SMALL, "small.xml")
    effects = catalogue(["torque_offset"])
    sets = [[], [Change("torque_offset", "elbow", {"T": 1e9})], [Change("torque_offset", "elbow", {"T": np.inf})]]
    parts = [window(robot, [recorded(robot)])]
    values = stack([encode(robot, effects, own) for own in sets])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        replay = open_loop_simulator(robot, effects, [robot], engine="c").replay(values, parts, np.zeros(3, int))
    assert np.isfinite(replay.qpos[0]).all()
    for lane in (1, 2):
        assert np.isnan(replay.qpos[lane, -1]).all() and np.isnan(replay.sensors[lane, -1]).all()
    alone = open_loop_simulator(robot, effects, [robot], engine="c").replay(
        {k: v[:1] for k, v in values.items()}, parts, np.zeros(1, int)
    )
    np.testing.assert_array_equal(alone.qpos[0], replay.qpos[0])
    assert capfd.readouterr() == ("", "") and list(tmp_path.iterdir()) == []


def test_terms_that_are_only_available_compile_nothing() -> None:
    robot = Robot.from_string(SMALL, "small.xml")
    acting = catalogue(["backlash", "stribeck_friction", "actuator_lag", "external_force"])
    parts, simulator = [window(robot, [recorded(robot)])], open_loop_simulator(robot, acting, [robot], engine="c")
    lanes = [[], [Change("backlash", "shoulder", {"half_gap": 0.05})], [Change("actuator_lag", "servo", {"tau": 0.05})]]
    with count_compilations() as compiled:
        replay = simulator.replay(stack([encode(robot, acting, c) for c in lanes]), parts, np.zeros(3, int))
    assert compiled.count == 0
    assert np.abs(replay.qpos[1:] - replay.qpos[0]).max(axis=(1, 2)).min() > 0.01


def test_the_centre_of_mass_of_a_body_that_mujoco_compiles_as_simple_can_move() -> None:
    robot = Robot.from_string(BOX, "box.xml")
    effects, (e,) = catalogue(["com_shift"]), catalogue(["com_shift"])
    shift = {"x": 0.15, "y": 0.0, "z": 0.0}
    time, nothing = 0.01 * np.arange(ROWS), np.zeros((ROWS, 0))
    unknown = np.full((ROWS, 7), np.nan)
    part = window(robot, [Recording("r.csv", time, nothing, nothing, nothing, unknown, unknown[:, :6])])
    values = stack([encode(robot, effects, own) for own in ([], [Change("com_shift", "box", shift)])])
    replay = open_loop_simulator(robot, effects, [robot], engine="c").replay(values, [part], np.zeros(2, int))
    spec = robot.spec.copy()
    e.write_mjcf(robot, spec, "box", shift)
    _, places = plain(spec.compile(), robot.home(), part)
    np.testing.assert_allclose(replay.qpos[1], places, rtol=0, atol=1e-5)
    assert np.abs(places - replay.qpos[0]).max() > 0.01


def test_inertia_of_a_term_does_not_depend_on_edits_of_other_lanes() -> None:
    robot = Robot.from_string(SMALL, "small.xml")
    effects, parts = catalogue(["armature", "law_inertia"]), [window(robot, [recorded(robot)])]
    law, edit = Change("law_inertia", "shoulder", {"I": 0.01}), Change("armature", "shoulder", {"I": 0.01})
    simulator = open_loop_simulator(robot, effects, [robot], engine="c")
    alone, beside = (
        simulator.replay(stack([encode(robot, effects, own) for own in sets]), parts, np.zeros(len(sets), int)).qpos
        for sets in ([[law]], [[law], [edit], []])
    )
    np.testing.assert_array_equal(alone[0], beside[0])
    assert np.abs(beside[0] - beside[2]).max() > 0.01


FLUNG = 100.0
"""Speed, rad/s, beyond which a robot has diverged, on every engine otherwise."""
WILD = ("law_fling", "law_square_fling", "law_whirl", "law_cubic_drag", "law_place_damping", "law_cube", "law_tow")
"""Laws that make the robot diverge where their numbers are in the middle of their bounds."""


def moderate(e: Effect, robot: Robot, site: str) -> Change:
    """An effect with numbers a third up from the lower of its bounds; of wild laws, a little."""
    numbers = {}
    for p, (low, high) in zip(e.parameters, e.bounds(robot, site), strict=True):
        low, high = max(low, -1e3), min(high, 1e3)
        share = 0.003 * high if e.name in WILD else low + 0.37 * (high - low)
        numbers[p.name] = 2.0 if p.refers else float(share)
    return Change(e.name, site or None, numbers)


@cache
def _replays(names: tuple[str, ...], engine: str) -> OpenLoopRollout:
    robot = Robot.from_string(SMALL, "small.xml")
    effects = catalogue(names)
    sets = [[moderate(e, robot, e.sites(robot)[0])] for e in effects]
    values = stack([encode(robot, effects, own) for own in [[], *sets]])
    simulator = open_loop_simulator(robot, effects, [robot], engine=engine, width=len(values[names[0]]))
    return simulator.replay(values, [window(robot, [recorded(robot, off=True)])], np.zeros(len(sets) + 1, int))


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["mjx", "lanes"])
def test_every_effect_agrees_with_other_engines(engine: str) -> None:
    robot = Robot.from_string(SMALL, "small.xml")
    names = tuple(e.name for e in every() if e.parameters and e.sites(robot) and e.kind != "controller")
    found, expected = (_replays(names, one) for one in ("c", engine))
    for lane, name in enumerate(("nominal", *names)):
        rows = np.logical_and.accumulate(np.abs(expected.qvel[lane]).max(axis=1) < FLUNG)  # false for NaN
        assert rows.sum() > 5, name
        motion, sensors = expected.qpos[lane, rows], expected.sensors[lane, rows]
        size = np.abs(motion - expected.qpos[0, rows]).max()
        np.testing.assert_allclose(found.qpos[lane, rows], motion, atol=1e-4 + 1e-3 * size, err_msg=name)
        # Forces of impacts, in single precision, differ by a percent.
        scale = np.maximum(np.abs(sensors).max(axis=0), 1e-2)
        np.testing.assert_allclose(found.sensors[lane, rows] / scale, sensors / scale, atol=1.5e-2, err_msg=name)
