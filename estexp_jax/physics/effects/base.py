"""The stages of a simulation at which effects act, an abstract class each, and what their laws are given.

Every subclass is written for one robot; populations are batches of values, mapped outside with `jax.vmap`.
"""

from __future__ import annotations

import abc
from collections.abc import Callable, Sequence
from typing import Any, ClassVar, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from mujoco import mjx

from estexp_jax.physics.effects.effect import NEVER, Array, Arrays, Effect, Parameter, neutral_values
from estexp_jax.physics.effects.elements import elements_of, site_rows
from estexp_jax.physics.effects.mounts import STILL, MountState
from estexp_jax.physics.model.robot import Robot

__all__ = [
    "NEVER",
    "Array",
    "Arrays",
    "BodyForce",
    "CommandLaw",
    "CommandShift",
    "Distortion",
    "Edit",
    "Effect",
    "JointForce",
    "JointState",
    "Parameter",
    "ReadingDrift",
    "ReadingShift",
    "Term",
    "neutral_values",
]


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


def _nothing() -> Array:
    return 0.0


def _still() -> MountState:
    return STILL


class DisplayedState(NamedTuple):
    """A hidden variable of a term at one of its elements that a sensor shows: times `factor`, beside its own."""

    column: int  #: of `sensordata`
    state: int
    element: int
    factor: float


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
    load: Callable[[], Array] = _nothing  #: -> sum of |torque| of all motors that drive a joint, each taken alone
    gravity: Callable[[], Array] = _nothing  #: -> torque that gravity puts on the joint, N m or N
    mount: Callable[[], MountState] = _still  #: -> the body at the term's site, which carries the joint


class JointForce(NamedTuple):
    """What a term adds to a joint for one step. A field left at its default is no array, so engines can skip it."""

    force: Array = 0.0  #: N m or N, explicit
    damping: Array = 0.0  #: on top of the joint's own: -damping * (speed at the end of the step)
    friction: Array = 0.0  #: on top of the joint's friction loss, MuJoCo's constraint
    inertia: Array = 0.0  #: on top of the joint's armature, kg m2 or kg
    motor: Array = 1.0  #: factor on the motor's force: its gain, bias and force range
    command: Array = 0.0  #: torque that the motor's command asks for on top, N m or N; sensors show it


class Term(Effect):
    """Acts during each step, elementwise over joints or motors: its sites, or all that a site stands for.

    A law is written once for arrays of any one shape: (n_elements,) for one robot on MJX, (n_elements, robots) in an
    engine that keeps the batch last. So it may use arithmetic and `jnp.where`, but no indices and no sums; engines
    gather what it sees and scatter what it gives. Friction and damping enter where MuJoCo integrates them implicitly:
    as explicit forces they would chatter, and differ from the native laws by milliradians at common step sizes.
    """

    #: Hidden variables of its own at each site.
    n_states: ClassVar[int] = 0
    #: Which of them is the torque of a motor that turns something else than the joint: sensors of the motor show it.
    motor_torque_state: ClassVar[int | None] = None

    @abc.abstractmethod
    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        """What happens in one step.

        Args:
            p: the parameters, one array each, in the order of `parameters`.
            joint: the joints.
            state: the hidden variables, one array each.

        Returns:
            The force, and the hidden variables after the step.
        """

    def initial(self, p: Arrays, q: Array, w: Array) -> Arrays:
        """The hidden variables of a robot that has been at a position for long."""
        return (jnp.zeros_like(q),) * self.n_states

    def motors(self, robot: Robot) -> np.ndarray | None:
        """Index of the actuator at each element, (n_elements,); None where its elements are joints."""
        if self.kind in ("joint", "body"):
            return None
        return np.array([robot.index("actuator", name) for name in elements_of(self, robot)], dtype=int)

    def bodies(self, robot: Robot) -> np.ndarray:
        """Index of the body at whose site each element is, (n_elements,), of a term of bodies."""
        index = np.array([robot.index("body", site) for site in self.sites(robot)], dtype=int)
        return index[site_rows(self, robot)]

    def displayed(self, robot: Robot) -> Sequence[DisplayedState]:
        """What sensors show of hidden variables, beside `motor_torque_state`."""
        return ()

    def dofs(self, robot: Robot) -> np.ndarray:
        """Velocity address of the joint at each element, (n_elements,): itself, or the one that an actuator drives."""
        motors = self.motors(robot)
        if motors is None:
            joints = [robot.index("joint", name) for name in elements_of(self, robot)]
        else:
            joints = [robot.joint_of_actuator(int(a)) for a in motors]
        return robot.model.jnt_dofadr[np.array(joints, dtype=int)]


class BodyForce(Effect):
    """Acts during each step, elementwise over bodies: where a body is -> a force on it."""

    @abc.abstractmethod
    def force_on_body(self, p: Arrays, position: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
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
        """Index of the actuator at each element, (n_elements,)."""
        return np.array([robot.index("actuator", name) for name in elements_of(self, robot)], dtype=int)


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
