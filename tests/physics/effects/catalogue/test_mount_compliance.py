"""A mount that gives: as a model that has springy joints there, in all engines, its sensors included."""

from functools import cache

import mujoco
import numpy as np
import pytest

from estexp_jax.physics.effects.catalogue.mount_compliance import MountCompliance
from estexp_jax.physics.effects.changes import Change, encode, stack
from estexp_jax.physics.effects.checks import effect_faults
from estexp_jax.physics.effects.registry import catalogue
from estexp_jax.physics.engines.choice import open_loop_simulator
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.physics.window import InitialState, window_of
from tests.physics.robots import robot

K, D = 900.0, 8.0
LEG = """
<body name="thigh_{0}" pos="{1} {2} -0.03"><joint name="hip_{0}" axis="0 1 0.2" damping="0.4" armature="0.01"/>
  <geom type="capsule" fromto="0 0 0 0 0 -0.25" size="0.03" mass="1.8"/>
  <body name="shank_{0}" pos="0 0 -0.25"><joint name="knee_{0}" axis="{3} 1 0" damping="0.4" armature="0.01"/>
    <geom type="capsule" fromto="0 0 0 0 0 -0.25" size="0.02" mass="0.6"/></body></body>
"""
XML = """
<mujoco model="stand">
  <compiler angle="radian"/><option timestep="0.001" integrator="implicitfast"/>
  <default><geom contype="0" conaffinity="0"/></default>
  <worldbody><body name="post" pos="0 0 0.5" quat="0.95 0 0 0.2">
    <body name="trunk" pos="0.1 0 0.5" quat="0.9 0.1 0.2 0">{springs}
      <geom type="box" size="0.25 0.1 0.06" mass="9" pos="0.03 0 0.02"/>
      <site name="imu" pos="0.1 0.05 0.02" quat="0.8 0.3 0 0.1"/>
      {left}{right}
      <body pos="-0.2 0 0"><joint name="tail" type="slide" axis="1 0.3 0" stiffness="60" damping="2"/>
        <geom size="0.04" mass="0.7"/></body>
    </body></body></worldbody>
  <actuator><position joint="hip_l" kp="60" kv="1.5"/><position joint="knee_l" kp="60" kv="1.5"/>
    <position joint="hip_r" kp="60" kv="1.5"/><position joint="knee_r" kp="60" kv="1.5"/></actuator>
  <sensor><gyro name="gyro" site="imu"/><accelerometer name="felt" site="imu"/></sensor>
</mujoco>
"""
JOINTS = 5


def model(springs: str = "") -> str:
    left, right = LEG.format("l", 0.2, 0.12, 0.1), LEG.format("r", 0.2, -0.1, 0.2)
    return XML.format(springs=springs, left=left, right=right)


def commands(rows: int) -> np.ndarray:
    phase = 2.0 * np.pi * np.cumsum(np.linspace(0.5, 4.0, rows)) * 0.005
    left, right = (0.4 * np.sin(phase), -0.5 + 0.4 * np.cos(phase)), (0.3 * np.cos(phase), -0.4 * np.sin(phase))
    return np.stack([*left, *right], axis=1)


@cache
def truth(rows: int = 201) -> tuple[np.ndarray, np.ndarray]:
    """Positions (rows, joints) and readings (rows, 6) of one whose trunk turns on springs, at a tenth of the step."""
    springs = [f'<joint axis="{a}" stiffness="{K}" damping="{D}"/>' for a in ("1 0 0", "0 1 0", "0 0 1")]
    it = mujoco.MjModel.from_xml_string(model("".join(springs)))
    it.opt.timestep = 0.0001
    data, found = mujoco.MjData(it), list[tuple[np.ndarray, np.ndarray]]()
    hold = commands(1)[0]
    for row in range(-400, rows):  # at rest first, so that all starts sagged
        if row >= 0:
            mujoco.mj_forward(it, data)  # under the command before
            found.append((data.qpos[3:].copy(), data.sensordata.copy()))
        data.ctrl[:] = hold if row < 0 else commands(rows)[row]
        mujoco.mj_step(it, data, 50)
    q, read = map(np.array, zip(*found, strict=True))
    return q, read


@cache
def replayed(engine: str) -> tuple[np.ndarray, np.ndarray]:
    """Positions (2, rows, joints) and readings (2, rows, 6): of the nominal robot, and of one with the effect."""
    xml = model()
    if engine == "lanes":  # which have no sensors on what cannot move
        xml = xml[: xml.index("<sensor>")] + "</mujoco>"
    subject, rows = Robot.from_string(xml, "stand.xml"), 201
    time, nothing = 0.005 * np.arange(rows), np.full((rows, 6), np.nan)
    recording = Recording("r", time, commands(rows), np.ones((rows, 4)), nothing, nothing[:, :5], nothing[:, :5])
    window = window_of([recording], 0, (0, rows - 1), 0.001, InitialState(truth()[0][0], np.zeros(JOINTS)))
    effects = catalogue(["mount_compliance"])
    sets: list[list[Change]] = [[], [Change("mount_compliance", "trunk", {"k": K, "d": D})]]
    values = stack([encode(subject, effects, changes) for changes in sets])
    simulator = open_loop_simulator(subject, effects, [subject], engine=engine, width=2)
    found = simulator.replay(values, [window], np.zeros(2, int))
    return found.qpos, found.sensors


@pytest.mark.parametrize("engine", ["c", "lanes", "mjx"])
def test_it_is_a_springy_joint_at_the_mount(engine: str) -> None:
    (nominal, gives), (still, moves) = replayed(engine)
    q, read = truth()
    size = np.sqrt(np.mean((nominal - q) ** 2, axis=0))
    assert size.max() > 0.01 and (np.sqrt(np.mean((gives - q) ** 2, axis=0)) < 0.12 * size.max()).all()
    if engine == "lanes":
        return
    for part, share in ((slice(0, 3), 0.1), (slice(3, 6), 0.25)):  # an accelerometer shows it a step and a half late
        gone = np.sqrt(np.mean((still - read)[8:, part] ** 2))
        assert np.sqrt(np.mean((moves - read)[8:, part] ** 2)) < share * gone


def test_it_acts_on_what_a_welded_body_carries() -> None:
    subject = Robot.from_string(model(), "stand.xml")
    assert MountCompliance().sites(subject) == ("trunk",)  # the post has no mass
    assert len(MountCompliance().dofs(subject)) == JOINTS
    assert effect_faults(MountCompliance(), subject) == []
    assert MountCompliance().sites(robot("quadruped")) == ()
    elsewhere = model().replace('<geom size="0.04" mass="0.7"/>', '<geom size="0.04" mass="0.7"/><site name="tip"/>')
    shown = elsewhere.replace('<gyro name="gyro" site="imu"/>', '<gyro name="gyro" site="tip"/>')
    assert MountCompliance().sites(Robot.from_string(shown, "tail.xml")) == ()
