"""What a hypothesis about reality is made of: effects, each acting at its own moment of a simulation.

An effect knows where it can act on a robot (its sites) and how strongly (its parameters). Its values on one robot are
an array (n_sites, n_parameters); at `neutral` everywhere, the simulation is the nominal one. Populations are batches of
such arrays: every subclass is written for one robot and batched outside with `jax.vmap`.
"""

from __future__ import annotations

import abc
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple, final

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from mujoco import mjx

from estexp_jax.physics.model.robot import Robot

Array = Any
"""An array over sites, or a number."""
Arrays = tuple[Array, ...]

NEVER = 1e6
"""Neutral value of limits and the like: no robot gets there."""


@final
@dataclass(frozen=True)
class Parameter:
    """One number of an effect.

    Attributes:
        name: as in findings and on the command line.
        unit: SI; empty for a ratio.
        neutral: the value at which the effect is absent.
        signed: whether both signs make sense.
        refers: a kind of element, where the number is 1 + the index of one of these; 0 is none.
    """

    name: str
    unit: str
    neutral: float = 0.0
    signed: bool = False
    refers: str = ""


class Effect(abc.ABC):
    """A way in which a robot may differ from its simulator.

    Class attributes:
        name: as in findings.
        kind: kind of element it acts on: joint, actuator, sensor, body, environment or controller.
        side: plant, command or sensor.
        parameters: its numbers, in the order of the value array's columns.
        equation: what it does, as text.
        in_mjcf: whether MJCF has a parameter for it.
        named: whether it is told under its name; else it is an unknown law, and told by its equation.
        source: where the law is described.
    """

    name: ClassVar[str]
    kind: ClassVar[str]
    side: ClassVar[str] = "plant"
    parameters: ClassVar[tuple[Parameter, ...]]
    equation: ClassVar[str]
    in_mjcf: ClassVar[bool] = False
    named: ClassVar[bool] = True
    source: ClassVar[str] = ""
    #: Parts of the model that must be there when MJX compiles it, or later values of them do nothing; see `mjx_model`.
    arms: ClassVar[tuple[str, ...]] = ()
    #: Flags of MJCF's options with any of which disabled it does nothing.
    flags: ClassVar[tuple[str, ...]] = ()

    @abc.abstractmethod
    def sites(self, robot: Robot) -> tuple[str, ...]:
        """Names of the elements it can act on; `("",)` for the environment; may be empty."""

    @abc.abstractmethod
    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        """Plausible (low, high) of each parameter at a site, in its unit."""

    @abc.abstractmethod
    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        """What it says about the robot, in plain words with numbers."""

    def told(self, values: Mapping[str, float]) -> tuple[str, Mapping[str, float]]:
        """The name under which it is reported at these values, and those of them that this name has."""
        return self.name, values

    def numbered(self, values: Mapping[str, float]) -> str:
        """What it does, as text, with its numbers where it has no name to know it by."""
        return self.equation

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Put the effect into a description, where MJCF has a place for it; `values` holds every parameter."""
        raise NotImplementedError(f"{self.name} has no place in MJCF")


class Edit(Effect):
    """Acts before the rollout: model -> model."""

    @abc.abstractmethod
    def edit(self, robot: Robot, model: mjx.Model, values: jax.Array) -> mjx.Model:
        """The model with the effect in it.

        Args:
            robot: the nominal robot, static.
            model: one robot's model.
            values: (n_sites, n_parameters).
        """

    #: Whether masses or inertias change, so that constants derived from them become stale.
    stales_inertia: ClassVar[bool] = False


class JointState(NamedTuple):
    """What a term sees of its sites' joints at the beginning of a physics step.

    At a site of kind actuator, "the motor" is that actuator alone; at a joint, all that drive it, taken together.
    What a command asks for is its share of the motor's torque, without limits: gear gain command in all; of a position
    servo, what goes beyond rest is that of the way left to go, of other motors all.
    """

    q: Array  #: position, rad or m
    w: Array  #: speed
    torque: Array  #: of the motor on the joint, N m or N, after what terms before made of it
    on: Array  #: 1.0 where the motor is on
    dt: Array  #: length of this step, s
    limit: Array  #: largest torque that the motor can give, N m or N
    armature: Array  #: rotor inertia at the joint, kg m2 or kg
    torque_at: Callable[[Array, Array], Array]  #: (q, w) -> torque of the motor if it sat at q and turned at w
    torque_of: Callable[[Array], Array]  #: 1 + index of a joint -> motor torque at that joint; 0 for no joint
    motion_of: Callable[[Array], tuple[Array, Array]]  #: 1 + index of a joint -> its (q, w); zeros for no joint
    asked: Callable[[], tuple[Array, Array]]  #: -> torque that the motor's command asks for in all, and beyond rest


class JointForce(NamedTuple):
    """What a term adds to a joint for one step. A field left at its default is no array, so engines can skip it."""

    force: Array = 0.0  #: N m or N, explicit
    damping: Array = 0.0  #: on top of the joint's own: -damping * (speed at the end of the step)
    friction: Array = 0.0  #: on top of the joint's friction loss, MuJoCo's constraint
    inertia: Array = 0.0  #: on top of the joint's armature, kg m2 or kg
    motor: Array = 1.0  #: factor on the motor's force: its gain, bias and force range
    command: Array = 0.0  #: torque that the motor's command asks for on top, N m or N; sensors show it


class Term(Effect):
    """Acts during each step, elementwise over its sites.

    A law is written once for arrays of any one shape: (n_sites,) for one robot on MJX, (n_sites, robots) in an engine
    that keeps the batch last. So it may use arithmetic and `jnp.where`, but no indices and no sums; engines gather what
    it sees and scatter what it gives. Friction and damping enter where MuJoCo integrates them implicitly: as explicit
    forces they would chatter, and differ from the native laws by milliradians at common step sizes.
    """

    #: Hidden variables of its own at each site.
    n_states: ClassVar[int] = 0
    #: Which of them is the torque of a motor that turns something else than the joint: sensors of the motor show it.
    shows: ClassVar[int | None] = None

    @abc.abstractmethod
    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        """What happens in one step.

        Args:
            p: the parameters, one array each, in the order of `parameters`.
            moment: the joints.
            state: the hidden variables, one array each.

        Returns:
            The force, and the hidden variables after the step.
        """

    def initial(self, p: Arrays, q: Array, w: Array) -> Arrays:
        """The hidden variables of a robot that has been at a position for long."""
        return (jnp.zeros_like(q),) * self.n_states

    def dofs(self, robot: Robot) -> np.ndarray:
        """Velocity address of the joint at each site, (n_sites,): the joint itself, or the one an actuator drives."""
        index = [robot.index(self.kind, site) for site in self.sites(robot)]
        joints = [robot.joint_of_actuator(i) for i in index] if self.kind == "actuator" else index
        return robot.model.jnt_dofadr[np.array(joints, dtype=int)]


class BodyForce(Effect):
    """Acts during each step, elementwise over bodies: where a body is -> a force on it."""

    @abc.abstractmethod
    def pull(self, p: Arrays, position: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
        """Force at the centre of mass, N, from the position of the centre of mass, m, both in world axes."""


class CommandLaw(Effect):
    """Acts between the command and the motor in each step, elementwise over actuators, like a `Term` over joints."""

    side: ClassVar[str] = "command"
    #: Hidden variables of its own at each site.
    n_states: ClassVar[int] = 0

    @abc.abstractmethod
    def act(self, p: Arrays, command: Array, idle: Array, dt: Array, state: Arrays) -> tuple[Array, Arrays]:
        """The command that the motor obeys, and the hidden variables after the step.

        Args:
            p: the parameters, one array each.
            command: what is commanded, within the actuator's control range.
            idle: the command at which the motor would give no torque now: for a position servo where it is, for a
                velocity servo its speed, for others 0.
            dt: length of the step, s.
            state: the hidden variables, one array each.
        """

    def initial(self, p: Arrays, command: Array) -> Arrays:
        """The hidden variables where a command has been in force for long."""
        return (command,) * self.n_states

    def actuators(self, robot: Robot) -> np.ndarray:
        """Index of the actuator at each site, (n_sites,)."""
        return np.array([robot.index("actuator", site) for site in self.sites(robot)], dtype=int)


class CommandShift(Effect):
    """Acts between the command and the motor: says how late each command arrives."""

    side: ClassVar[str] = "command"

    @abc.abstractmethod
    def shift(self, robot: Robot, values: np.ndarray) -> np.ndarray:
        """Time by which each command is late, (..., nu), s, of values (..., n_sites, n_parameters)."""


class ReadingShift(Effect):
    """Acts between the robot and its log: says how old each reading is."""

    side: ClassVar[str] = "sensor"

    @abc.abstractmethod
    def shift(self, robot: Robot, values: np.ndarray) -> np.ndarray:
        """Age of each reading, (..., nsensordata), s, of values (..., n_sites, n_parameters)."""


class ReadingDrift(Effect):
    """Acts between the robot and its log: what each reading gains with time."""

    side: ClassVar[str] = "sensor"

    @abc.abstractmethod
    def rate(self, robot: Robot, values: np.ndarray) -> np.ndarray:
        """Gain of each reading (..., nsensordata), in its unit per second, of values (..., n_sites, n_parameters).

        The recording's time counts, from its beginning.
        """


class Distortion(Effect):
    """Acts after the rollout: readings -> readings."""

    side: ClassVar[str] = "sensor"

    @abc.abstractmethod
    def distort(self, robot: Robot, readings: jax.Array, values: jax.Array) -> jax.Array:
        """The faulty readings (..., nsensordata) of true ones."""

    @abc.abstractmethod
    def restore(self, robot: Robot, readings: Any, values: Any) -> Any:
        """The true readings of faulty ones: the inverse of `distort`, for arrays of numpy or JAX."""


def neutral_values(effect: Effect, n_sites: int) -> list[list[float]]:
    """Values (n_sites, n_parameters) at which an effect does nothing."""
    return [[p.neutral for p in effect.parameters] for _ in range(n_sites)]
