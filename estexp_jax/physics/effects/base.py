"""What a hypothesis about reality is made of: effects, each acting at one of four moments.

An effect knows where it can act on a robot (its sites) and how strongly (its parameters). Its values on one robot are
an array (n_sites, n_parameters); at `neutral` everywhere, the simulation is the nominal one. Populations are batches of
such arrays: every subclass is written for one robot and batched outside with `jax.vmap`.
"""

from __future__ import annotations

import abc
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple, final

import jax
import mujoco
from mujoco import mjx

from estexp_jax.physics.robot import Robot


@final
@dataclass(frozen=True)
class Parameter:
    """One number of an effect.

    Attributes:
        name: as in findings and on the command line.
        unit: SI; empty for a ratio.
        neutral: the value at which the effect is absent.
        signed: whether both signs make sense.
    """

    name: str
    unit: str
    neutral: float = 0.0
    signed: bool = False


class Effect(abc.ABC):
    """A way in which a robot may differ from its simulator.

    Class attributes:
        name: as in findings.
        kind: kind of element it acts on: joint, actuator, sensor, body, environment or controller.
        side: plant, command or sensor.
        parameters: its numbers, in the order of the value array's columns.
        equation: what it does, as text.
        in_mjcf: whether MJCF has a parameter for it.
        source: where the law is described.
    """

    name: ClassVar[str]
    kind: ClassVar[str]
    side: ClassVar[str] = "plant"
    parameters: ClassVar[tuple[Parameter, ...]]
    equation: ClassVar[str]
    in_mjcf: ClassVar[bool] = False
    source: ClassVar[str] = ""

    @abc.abstractmethod
    def sites(self, robot: Robot) -> tuple[str, ...]:
        """Names of the elements it can act on; `("",)` for the environment; may be empty."""

    @abc.abstractmethod
    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        """Plausible (low, high) of each parameter at a site, in its unit."""

    @abc.abstractmethod
    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        """What it says about the robot, in plain words with numbers."""


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

    #: Model fields that must be non-zero when MJX compiles the model, or their later edits do nothing.
    arms: ClassVar[tuple[str, ...]] = ()
    #: Whether masses or inertias change, so that constants derived from them become stale.
    stales_inertia: ClassVar[bool] = False

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Put the effect into a description, where MJCF has a place for it."""
        raise NotImplementedError(f"{self.name} has no place in MJCF")


class Moment(NamedTuple):
    """What a term sees at the beginning of a physics step of one robot."""

    qpos: jax.Array  #: (nq,)
    qvel: jax.Array  #: (nv,)
    ctrl: jax.Array  #: (nu,) command in force
    enable: jax.Array  #: (nu,) 1.0 where the motor is on
    motor: jax.Array  #: (nv,) motor torque at the joints, N m or N


class Term(Effect):
    """Acts during each step, as the state's own parameters: (state, command) -> model of this step.

    Friction and damping enter where MuJoCo integrates them implicitly, not as an external force, which would differ
    from the native law by several milliradians at common step sizes.
    """

    arms: ClassVar[tuple[str, ...]] = ()

    @abc.abstractmethod
    def act(self, robot: Robot, model: mjx.Model, moment: Moment, values: jax.Array) -> mjx.Model:
        """The model of this one step."""

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Put the effect into a description, where MJCF has a place for it."""
        raise NotImplementedError(f"{self.name} has no place in MJCF")


class CommandShift(Effect):
    """Acts between the command and the motor: says how late each command arrives."""

    side: ClassVar[str] = "command"

    @abc.abstractmethod
    def shift(self, robot: Robot, values: jax.Array) -> jax.Array:
        """Time by which each command is late, (nu,), s."""


class Distortion(Effect):
    """Acts after the rollout: readings -> readings."""

    side: ClassVar[str] = "sensor"

    @abc.abstractmethod
    def distort(self, robot: Robot, readings: jax.Array, values: jax.Array) -> jax.Array:
        """The faulty readings (..., nsensordata) of true ones."""

    @abc.abstractmethod
    def restore(self, robot: Robot, readings: Any, values: Any) -> Any:
        """The true readings of faulty ones: the inverse of `distort`, for arrays of numpy or JAX."""


class ControllerFault(Effect):
    """Acts inside the controller: network -> network."""

    @abc.abstractmethod
    def damage(self, robot: Robot, network: Any, values: jax.Array) -> Any:
        """The network with the fault in it."""


def neutral_values(effect: Effect, n_sites: int) -> list[list[float]]:
    """Values (n_sites, n_parameters) at which an effect does nothing."""
    return [[p.neutral for p in effect.parameters] for _ in range(n_sites)]


def scatter(values: jax.Array, indices: Sequence[int], like: jax.Array) -> jax.Array:
    """Values of the sites (n_sites,) laid out over all elements of `like`'s first axis, zero elsewhere."""
    import jax.numpy as jnp

    return jnp.zeros(like.shape[0], like.dtype).at[jnp.asarray(indices, dtype=int)].set(values)
