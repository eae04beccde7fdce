"""Robots with an effect in them, simulated by our own terms and by MuJoCo alone from what was exported."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

from estexp_jax.physics.effects.changes import Change, encode, parse_change, stack
from estexp_jax.physics.effects.registry import catalogue, named_effects
from estexp_jax.physics.effects.written import written
from estexp_jax.physics.engines.c.plain_replay import PlainReplay
from estexp_jax.physics.engines.choice import open_loop_simulator
from estexp_jax.physics.engines.open_loop import OpenLoopRollout
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.physics.window import InitialState, StateEstimate, Window, window_of

# An arm of two servos on a column, with a hand to be pushed.
SERVOS = """
<mujoco model="servos">
  <compiler angle="radian" autolimits="true"/>
  <option timestep="0.002" integrator="{integrator}"/>
  <worldbody>
    <geom name="floor" type="plane" size="2 2 0.1"/>
    <body name="base" pos="0 0 0.4">
      <geom type="cylinder" size="0.05 0.3" mass="2"/>
      <body name="upper" pos="0 0 0.3">
        <joint name="shoulder" axis="0 1 0" damping="0.05" armature="0.005"/>
        <geom type="capsule" fromto="0 0 0 0.25 0 0" size="0.02" mass="0.4" contype="0" conaffinity="0"/>
        <body name="lower" pos="0.25 0 0">
          <joint name="elbow" axis="0 1 0" damping="0.03" armature="0.004"/>
          <geom type="capsule" fromto="0 0 0 0.2 0 0" size="0.02" mass="0.2"/>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position name="lift" joint="shoulder" kp="20" kv="0.4" forcerange="-6 6" ctrlrange="-2 2"/>
    <position name="bend" joint="elbow" kp="10" kv="0.2" gear="1" forcerange="-3 3" ctrlrange="-2 2"/>
  </actuator>
  <sensor>
    <jointpos name="high" joint="shoulder"/>
    <jointpos name="bent" joint="elbow"/>
    <jointvel name="speed" joint="elbow"/>
  </sensor>
  <keyframe><key name="home" qpos="0.2 0.4" ctrl="0.2 0.4"/></keyframe>
</mujoco>
"""

# A cart on a rail and the pendulum on it, both with motors; geared.
MOTORS = """
<mujoco model="motors">
  <compiler autolimits="true"/>
  <option timestep="0.004" integrator="{integrator}"/>
  <worldbody>
    <body name="cart" pos="0 0 1">
      <joint name="rail" type="slide" axis="1 0 0" damping="0.5" frictionloss="0.05"/>
      <geom type="box" size="0.1 0.05 0.05" mass="1"/>
      <body name="bob">
        <joint name="swing" axis="0 1 0" damping="0.02" stiffness="0.3" springref="10" armature="0.003"/>
        <geom type="capsule" fromto="0 0 0 0 0 -0.3" size="0.02" mass="0.3"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <motor name="push" joint="rail" gear="5" ctrlrange="-2 2"/>
    <motor name="turn" joint="swing" gear="2" ctrlrange="-1 1"/>
  </actuator>
  <sensor>
    <jointpos name="place" joint="rail"/>
    <jointpos name="lean" joint="swing"/>
  </sensor>
</mujoco>
"""
_ROBOTS = {"servos": SERVOS, "motors": MOTORS}
_SIZE = {"servos": 0.6, "motors": 0.5}
REST, DURATION, PERIOD = 0.5, 1.5, 0.02


class Exported(NamedTuple):
    """Readings (rows, nsensordata) of one motion."""

    planted: np.ndarray  #: by our terms
    alone: np.ndarray  #: by MuJoCo alone
    nominal: np.ndarray

    @property
    def share(self) -> float:
        """How far MuJoCo alone is from our terms, as a share of how far the effect moves the robot."""
        return _rms(self.alone - self.planted) / _rms(self.nominal - self.planted)


def _rms(x: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(x))))


@cache
def robot_of(name: str, integrator: str = "implicitfast") -> Robot:
    """One of the robots."""
    return Robot.from_string(_ROBOTS[name].format(integrator=integrator))


def motion(robot: Robot, size: float, seed: int = 0) -> Window:
    """Sums of sines as commands, each held for a period, after some rest at home."""
    rng, home = np.random.default_rng(seed), robot.home()
    time = np.arange(-REST, DURATION, PERIOD)
    phases = rng.uniform(0.0, 2.0 * np.pi, (robot.model.nu, 3))
    waves = np.sin(2.0 * np.pi * np.array([0.4, 0.9, 1.7])[:, None] * time + phases[..., None]).sum(axis=1)
    rest = home if robot.model.nkey else np.zeros(robot.model.nu)
    ctrl = rest + size * np.tanh(np.maximum(time, 0.0) / 0.2)[:, None] * waves.T / 2.0
    shape, widths = (len(time), robot.model.nactuator), (robot.model.nsensordata, robot.model.nq, robot.model.nv)
    sensor, qpos, qvel = (np.full((len(time), n), np.nan) for n in widths)
    recording = Recording("motion", time, ctrl, np.ones(shape), sensor, qpos, qvel)
    start, still = InitialState(home, np.zeros(robot.model.nv)), np.zeros((len(time), robot.model.nv))
    path = StateEstimate(time, np.tile(home, (len(time), 1)), still)
    first = int(np.searchsorted(time, -0.5 * PERIOD))
    return window_of([recording], 0, (first, len(time) - 1), float(robot.model.opt.timestep), start, path)


def ours(robot: Robot, changes: list[Change], window: Window) -> OpenLoopRollout:
    """By our own terms, in the C engine, at the robot's step."""
    effects = catalogue(dict.fromkeys(c.effect for c in changes)) or named_effects()[:1]
    simulator = open_loop_simulator(robot, effects, [robot], engine="c", width=1)
    return simulator.replay(stack([encode(robot, effects, changes)]), [window], np.zeros(1, int))


def exported(name: str, text: str, integrator: str = "implicitfast", finer: int = 1) -> Exported:
    """A robot with effects, joined by +, by our terms, by MuJoCo alone, and without them, at a part of its step."""
    robot = robot_of(name, integrator).finer(finer)
    changes, window = [parse_change(t, robot) for t in text.split(" + ")], motion(robot, _SIZE[name])
    alone = PlainReplay(robot, written(robot, changes).compile()).replay([window])
    planted, nominal = ours(robot, changes, window), ours(robot, [], window)
    return Exported(planted.sensors[0], alone.sensors[0], nominal.sensors[0])
