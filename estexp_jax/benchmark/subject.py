"""The robots that `bench` races, whatever the engine."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import final

import mujoco
import numpy as np

from estexp_jax.errors import InputError
from estexp_jax.package_data import model_path
from estexp_jax.physics.effects.catalogue.body_mass import BodyMass
from estexp_jax.physics.effects.catalogue.gravity_tilt import GravityTilt
from estexp_jax.physics.effects.catalogue.joint_jam import JointJam
from estexp_jax.physics.effects.catalogue.motor_weakness import MotorWeakness
from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.effects.sites import actuator_sites, body_sites, scalar_joint_sites
from estexp_jax.physics.engines.c.reference_loops import CRollouts, PooledSimulator, StartState, at_rest
from estexp_jax.physics.engines.closed_loop_agreement import SampledStates, sample_states
from estexp_jax.physics.engines.controller_interface import Interface, interface_of
from estexp_jax.physics.engines.policy import Policy
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.model.travel import root_position_map
from estexp_jax.recovery.control.network import RecurrentPolicy

EFFECTS = (BodyMass.name, MotorWeakness.name, JointJam.name, GravityTilt.name)
"""What differs from robot to robot: masses and inertias, gains and force ranges, damping, gravity."""
_STATES, _DRAWN, _REST = 256, 200, 0.5
"""States in which engines are compared; different robots in a population; time to come to rest before a race, s."""
_FEET = "foot"


@final
@dataclass(frozen=True)
class BenchmarkTask:
    """What all engines are given.

    Attributes:
        model: an MJCF file; None: the quadruped that comes with the package.
        feet: the quadruped with its feet as only contacts.
        population: robots.
        steps: control steps.
        substeps: physics steps a control step.
        seed: of controllers and edits.
    """

    model: str | None = None
    feet: bool = False
    population: int = 200
    steps: int = 1000
    substeps: int = 4
    seed: int = 0


@final
class BenchmarkRobots:
    """The robots of a race."""

    def __init__(self, race: BenchmarkTask) -> None:
        """Load and draw them.

        Raises:
            InputError: the model cannot be used.
        """
        self.race, self.robot = race, load(race.model, feet=race.feet)
        root_position_map(self.robot)  # refuses robots that cannot travel, as any engine would later
        self.face: Interface = interface_of(self.robot)
        self.policy: Policy = RecurrentPolicy()
        self.rng = np.random.default_rng(race.seed)
        size = (race.population, self.policy.n_weights(self.face.n_inputs, self.face.n_outputs))
        self.weights = self.rng.uniform(-1.0, 1.0, size).astype(np.float32)
        self.sets = [small_changes(self.robot, self.rng) for _ in range(min(race.population, _DRAWN))]
        self.start: StartState = at_rest(self.robot.model, self.robot.home(), self.face.ctrl_centre, _REST)

    @property
    def course(self) -> CRollouts:
        """What the C engine is given: the nominal robot."""
        return CRollouts(self.robot.model, self.face, self.policy, self.start, self.weights, self.race.substeps)

    @cached_property
    def recorded(self) -> np.ndarray:
        """Commands (population, steps, nu) for replays: those of the closed loop."""
        return PooledSimulator(self.course).record(self.race.population, self.race.steps)

    @cached_property
    def states(self) -> SampledStates:
        """Where engines are compared."""
        return sample_states(self.robot, self.face, _STATES, self.race.seed)


def load(model: str | None, *, feet: bool) -> Robot:
    """The robot of a race.

    Raises:
        InputError: there is no such model, or `feet` is asked of one.
    """
    if model is not None and feet:
        raise InputError("only the quadruped has a variant with feet alone", where="--feet", right="leave out --model")
    robot = Robot.from_xml(Path(model) if model is not None else model_path("quadruped"))
    if not feet:
        return robot
    spec = robot.spec.copy()
    for geom in spec.geoms:
        if geom.type != mujoco.mjtGeom.mjGEOM_PLANE and not geom.name.startswith(_FEET):
            geom.contype = geom.conaffinity = 0
    return Robot.from_spec(spec, f"{robot.source}, feet only")


def small_changes(robot: Robot, rng: np.random.Generator) -> list[Change]:
    """One robot's own edits: masses and motor strengths +-10 %, some jam in each joint, a tilt of up to 3 degrees."""
    changes = [Change(GravityTilt.name, None, {"angle": rng.uniform(-0.05, 0.05)})]
    for name in body_sites(robot):
        mass = float(robot.model.body_mass[robot.index("body", name)])
        changes.append(Change(BodyMass.name, name, {"dm": mass * rng.uniform(-0.1, 0.1)}))
    changes += [Change(MotorWeakness.name, name, {"loss": rng.uniform(-0.1, 0.1)}) for name in actuator_sites(robot)]
    changes += [Change(JointJam.name, name, {"f": rng.uniform(0.0, 0.05)}) for name in scalar_joint_sites(robot)]
    return changes
