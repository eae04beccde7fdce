"""Recordings of robots with a concealed effect, simulated by the C engine from MJCF edited as text, at a finer step."""

from collections.abc import Callable, Generator
from dataclasses import dataclass
from functools import cache
from typing import Any
from unittest.mock import patch

import mujoco
import numpy as np

from estexp_jax.discovery import comparison
from estexp_jax.discovery.diagnosis import Case, Diagnosis, ExplainConfig
from estexp_jax.discovery.explain import explain
from estexp_jax.discovery.hypotheses import simulated
from estexp_jax.discovery.problem import Problem
from estexp_jax.physics.effects.registry import Catalogue, catalogue
from estexp_jax.physics.engines.choice import open_loop_simulator
from estexp_jax.physics.engines.open_loop import OpenLoopSimulator
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording

RATE = 100.0
"""Rows a second."""
_BEFORE = 50
"""Rows for which the robot is commanded before the recording begins."""

# A servo turns a hanging arm.
ONE = """
<mujoco model="one">
  <compiler angle="radian" autolimits="true"/>
  <option timestep="0.005"/>
  <worldbody>
    <body name="arm">
      <joint name="shaft" axis="0 1 0" damping="0.02"/>
      <geom name="bar" type="capsule" fromto="0 0 0 0 0 -0.3" size="0.02" mass="0.5"/>
    </body>
  </worldbody>
  <actuator><position name="servo" joint="shaft" kp="4" kv="0.1" forcerange="-3 3"/></actuator>
  <sensor><jointpos name="angle" joint="shaft"/></sensor>
</mujoco>
"""

# Torques move a planar arm with encoders only.
TWO = """
<mujoco model="two">
  <compiler angle="radian" autolimits="true"/>
  <option timestep="0.005"/>
  <worldbody>
    <body name="upper">
      <joint name="shoulder" axis="0 1 0" damping="0.05"/>
      <geom name="bar" type="capsule" fromto="0 0 0 0 0 -0.25" size="0.02" mass="0.6"/>
      <body name="lower" pos="0 0 -0.25">
        <joint name="elbow" axis="0 1 0" damping="0.03"/>
        <geom name="rod" type="capsule" fromto="0 0 0 0 0 -0.2" size="0.015" mass="0.3"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <motor name="hip" joint="shoulder" ctrlrange="-2 2"/>
    <motor name="knee" joint="elbow" ctrlrange="-1 1"/>
  </actuator>
  <sensor><jointpos name="upper_angle" joint="shoulder"/><jointpos name="lower_angle" joint="elbow"/></sensor>
</mujoco>
"""

# Beside the first arm, a block lies on a level track without friction.
IDLE = ONE.replace(
    "</worldbody>",
    '<body name="box" pos="0 1 0"><joint name="track" type="slide" axis="1 0 0"/><geom size="0.02" mass="0.1"/></body>'
    "</worldbody>",
).replace("</sensor>", '<jointpos name="place" joint="track"/></sensor>')

XML = {"one": ONE, "two": TWO, "idle": IDLE}
REACH = {"one": np.array([1.2]), "two": np.array([1.5, 0.5]), "idle": np.array([1.2])}
"""Size of the commands."""


@dataclass(frozen=True)
class Plant:
    """What the real robot has that its simulator has not.

    Attributes:
        old, new: text of the MJCF and what stands there in truth.
        delay: of all commands, s.
        bias: of the first encoder, rad.
        drift: of the first encoder, rad/s.
        off: whether all motors are off in the middle of each recording.
        finer: the robot steps so many times as often as its nominal simulator.
        law: force on the joints from the time, positions and speeds, that no MJCF has.
    """

    old: str = ""
    new: str = ""
    delay: float = 0.0
    bias: float = 0.0
    drift: float = 0.0
    off: bool = False
    finer: int = 5
    law: Callable[[float, np.ndarray, np.ndarray], Any] | None = None


_LOOSE, _SERVO = 'damping="0.02"', 'kp="4" kv="0.1" forcerange="-3 3"'
CASES = {
    "viscous_friction@shaft": ("one", Plant(_LOOSE, 'damping="0.12"', off=True), 7),
    "coulomb_friction@shaft": ("one", Plant(_LOOSE, f'{_LOOSE} frictionloss="0.15"'), 7),
    "armature@shaft": ("one", Plant(_LOOSE, f'{_LOOSE} armature="0.02"'), 7),
    "command_delay@servo": ("one", Plant(delay=0.04), 7),
    "motor_weakness@servo": (
        "one",
        Plant(_SERVO, 'kp="2" kv="0.05" forcerange="-1.5 1.5"'),
        7,
    ),
    "sensor_bias@angle": ("one", Plant(bias=0.08), 7),
    "coulomb_friction@elbow": ("two", Plant('damping="0.03"', 'damping="0.03" frictionloss="0.06"'), 8),
    "motor_weakness@hip": ("two", Plant('<motor name="hip"', '<motor name="hip" gear="0.6"'), 8),
    "body_mass@lower": ("two", Plant('size="0.015" mass="0.3"', 'size="0.015" mass="0.5"'), 8),
    "nothing": ("one", Plant(), 9),
    "nothing, two joints": ("two", Plant(), 9),
    "heavier by 8 %": ("one", Plant('mass="0.5"', 'mass="0.54"'), 9),
    "damped by 10 % more": ("two", Plant('damping="0.05"', 'damping="0.055"'), 9),
    "exact": ("one", Plant(finer=1), 9),
}
"""Robot, what is planted in it, seed."""
TRUTH = {
    "viscous_friction@shaft": 0.1,
    "coulomb_friction@shaft": 0.15,
    "armature@shaft": 0.02,
    "command_delay@servo": 0.04,
    "motor_weakness@servo": 0.5,
    "sensor_bias@angle": 0.08,
    "coulomb_friction@elbow": 0.06,
    "motor_weakness@hip": 0.4,
    "body_mass@lower": 0.2,
}
"""The planted effects' only parameter."""


@cache
def nominal(name: str) -> Robot:
    """A robot of `XML`, compiled once."""
    return Robot.from_string(XML[name], f"{name}.xml")


def record(
    name: str, plant: Plant, seed: int, *, role: str, length: float = 2.5, noise: float = 2e-4, bits: int = 12
) -> Recording:
    """One recording of the real robot: sums of sines as commands, encoders with noise and steps of a turn / 2^bits."""
    assert plant.old in XML[name]
    model = mujoco.MjModel.from_xml_string(XML[name].replace(plant.old, plant.new) if plant.old else XML[name])
    model.opt.timestep /= plant.finer
    data, rng = mujoco.MjData(model), np.random.default_rng(seed)
    n, inner = round(length * RATE) + 1, round(1.0 / (RATE * model.opt.timestep))
    command = commands(rng, np.arange(-_BEFORE, n) / RATE, REACH[name])
    late = round(plant.delay / model.opt.timestep)
    sent = np.repeat(command, inner, axis=0)
    enable, angles = np.ones((n, model.nu)), np.zeros((n, model.nq))
    enable[n // 3 : n // 2] = 0.0 if plant.off else 1.0
    gain, bias = model.actuator_gainprm.copy(), model.actuator_biasprm.copy()
    for k in range(_BEFORE * inner, len(sent)):  # in motion at the first row, like any log
        row = k // inner - _BEFORE
        if k % inner == 0:
            angles[row] = data.qpos
        model.actuator_gainprm[:], model.actuator_biasprm[:] = gain * enable[row, 0], bias * enable[row, 0]
        data.ctrl[:] = sent[k - late]
        if plant.law is not None:
            data.qfrc_applied[:] = plant.law((k / inner - _BEFORE) / RATE, data.qpos, data.qvel)
        mujoco.mj_step(model, data)
    quantum = 2.0 * np.pi / 2**bits
    read = np.round((angles + noise * rng.standard_normal(angles.shape)) / quantum) * quantum
    nothing, time = np.full((n, model.nq), np.nan), np.arange(n) / RATE
    read[:, 0] += plant.bias + plant.drift * time
    return Recording(f"{role}_{seed}.csv", time, command[_BEFORE:], enable, read, nothing, nothing, role)


def commands(rng: np.random.Generator, time: np.ndarray, reach: np.ndarray) -> np.ndarray:
    """Sums of three sines a motor, with a jump now and then."""
    shape = (3, len(reach))
    frequency, phase = rng.uniform(0.3, 1.8, shape), rng.uniform(0.0, 2.0 * np.pi, shape)
    waves = np.sin(2.0 * np.pi * frequency * time[:, None, None] + phase).sum(axis=1) / 2.0
    jumps = rng.choice([-0.4, 0.0, 0.4], size=(len(time) // 60 + 1, len(reach)))
    return reach * (waves + np.repeat(jumps, 60, axis=0)[: len(time)])


def case_of(name: str, plant: Plant, seed: int, *, trains: int = 3, tests: int = 1, **options: Any) -> Case:
    """Training recordings and test recordings of one robot, each moved otherwise."""
    roles = ["train"] * trains + ["test"] * tests
    recordings = tuple(record(name, plant, 100 * seed + i, role=role, **options) for i, role in enumerate(roles))
    return Case(nominal(name), recordings, (nominal(name),) * len(recordings))


FEW = (
    "viscous_friction",
    "coulomb_friction",
    "load_dependent_friction",
    "armature",
    "back_emf",
    "command_delay",
    "motor_weakness",
    "sensor_bias",
    "body_mass",
)
CONFIG = ExplainConfig(window=1.25, most=2, effects=FEW)
"""Windows of whole blocks of steps, so that nothing is simulated in vain; few effects, so that it is over soon."""


@cache
def shared_replayer(name: str, effects: tuple[str, ...] = simulated(CONFIG.effects)) -> OpenLoopSimulator:
    """One replayer, so one compilation, for all cases of a robot with these effects."""
    return open_loop_simulator(nominal(name), catalogue(effects), [nominal(name)])


def _shared(robot: Robot, effects: Catalogue, *_: Any, **__: Any) -> OpenLoopSimulator:
    return shared_replayer(robot.source.removesuffix(".xml"), tuple(e.name for e in effects))


def problem_of(case: Case, config: ExplainConfig = CONFIG) -> Problem:
    """The comparison of a case, without compiling anew."""
    with patch.object(comparison, "open_loop_simulator", _shared):
        return comparison.problem_of(case, config, {})


def explained(case: Case, config: ExplainConfig = CONFIG) -> Diagnosis:
    """The explanation of a case, without compiling anew."""
    with patch.object(comparison, "open_loop_simulator", _shared):
        return finished(explain(case, config))


def finished(steps: Generator[Any, None, Any]) -> Any:
    """What a generator returns at its end."""
    while True:
        try:
            next(steps)
        except StopIteration as end:
            return end.value
