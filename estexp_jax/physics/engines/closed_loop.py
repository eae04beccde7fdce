"""Closed loop, whatever the engine: robots with damage, each driven by its own controller."""

from __future__ import annotations

import abc
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from estexp_jax.physics.effects.changes import Values
from estexp_jax.physics.effects.controller_fault import ControllerFault
from estexp_jax.physics.effects.registry import Catalogue
from estexp_jax.physics.engines.batching import EngineChoice
from estexp_jax.physics.engines.controller_interface import Interface
from estexp_jax.physics.engines.mjx.capabilities import reduced_to_mjx
from estexp_jax.physics.engines.mjx.model import MjxModel, mjx_model
from estexp_jax.physics.engines.mjx.terms import Hidden, MjxStepStart
from estexp_jax.physics.engines.policy import Policy
from estexp_jax.physics.model.robot import Robot


class BodyState(NamedTuple):
    """State of one robot; batched, every array has a leading axis."""

    qpos: Any  #: (nq,)
    qvel: Any  #: (nv,)
    warmstart: Any  #: (nv,) the solver's last solution
    sensordata: Any  #: (nsensordata,) of the last physics step
    hidden: Any  #: variables of effects that have some, as the engine keeps them


class Rollout(NamedTuple):
    """A rollout of robots; every array has the robots as first axis.

    Rows are control steps; only the first `steps` of them are filled.
    """

    readings: Any  #: (robots, rows, n_inputs) raw readings before the row's command acts; touch as +1/-1
    commands: Any  #: (robots, rows, nu)
    position: Any  #: (robots, rows, 3) of the root, m
    final: BodyState
    failed: Any  #: (robots,) bool: the simulation blew up


class ReadingOverride(NamedTuple):
    """Readings that controllers get: `factor` times the robot's own, touch as +1/-1, plus `added`.

    Both (robots, steps, n_inputs), raw. Factor 0 replays what was recorded; noise is added, and turns touch readings
    round.
    """

    factor: Any
    added: Any


def replace_readings(readings: np.ndarray) -> ReadingOverride:
    """Readings (..., steps, n_inputs) in place of the robots' own."""
    return ReadingOverride(np.zeros_like(readings), readings)


def override_reading(factor: Any, added: Any, reading: Any) -> Any:
    """As in `ReadingOverride`; at factor 0 the own reading has no influence, even if it is NaN."""
    return jnp.where(factor == 0.0, added, factor * reading + added)


class RobotInstance(NamedTuple):
    """One robot to simulate; batched, every array has a leading axis."""

    values: Values
    weights: Any  #: (n_weights,)
    start: BodyState


@dataclass(frozen=True, eq=False)
class ClosedLoopSimulator(abc.ABC):
    """Simulates populations of one robot in closed loop, all with one executable.

    Attributes:
        robot: the nominal robot.
        catalogue: the effects that `values` have an entry for.
        interface: inputs and outputs of controllers.
        policy: the controllers' equations.
        rows: longest rollout, control steps.
        substeps: physics steps a control step.
        width: robots in a chunk.
        choice: which engine it is, and why.
    """

    robot: Robot
    catalogue: Catalogue
    interface: Interface
    policy: Policy
    rows: int
    substeps: int
    width: int
    choice: EngineChoice

    @abc.abstractmethod
    def _run(self, lanes: RobotInstance, steps: int, *, active: bool, override: ReadingOverride | None) -> Rollout:
        """Simulate lanes for some control steps.

        Args:
            lanes: the robots.
            steps: control steps.
            active: false: all motors at home.
            override: readings that controllers get; None: the robots' own.
        """

    @abc.abstractmethod
    def _rested(self, values: Values) -> Any:
        """Hidden variables of robots that have been in their home posture for long, as `BodyState` has them."""

    @property
    def left_out(self) -> tuple[str, ...]:
        """What of the robot this engine leaves out; each follows "simulated without"."""
        return ()

    def finer(self, parts: int) -> ClosedLoopSimulator:
        """The same simulator at a part of the physics step."""
        return replace(self, robot=self.robot.finer(parts), substeps=self.substeps * parts)

    def home(self, values: Values) -> BodyState:
        """The states of robots in their home posture, at rest, for values (robots, n_sites, n_parameters)."""
        model, n = self.robot.model, _size(values)
        zeros = partial(np.zeros, dtype=np.float32)
        qpos = self.robot.home().astype(np.float32)
        one = (qpos, zeros(model.nv), zeros(model.nv), zeros(model.nsensordata))
        place, speed, warmstart, sensordata = (np.broadcast_to(x, (n, *x.shape)) for x in one)
        return BodyState(place, speed, warmstart, sensordata, self._rested(values))

    def settle(self, values: Values, steps: int) -> BodyState:
        """Let robots come to rest with all motors at home: the state a trial starts from.

        Args:
            values: (robots, n_sites, n_parameters) for each effect.
            steps: control steps.
        """
        weights = np.zeros((_size(values), self.n_weights), np.float32)
        return self._rollout(values, weights, self.home(values), steps, active=False).final

    def rollout(
        self, values: Values, weights: np.ndarray, start: BodyState, steps: int, override: ReadingOverride | None = None
    ) -> Rollout:
        """Drive robots by their controllers.

        Args:
            values: (robots, n_sites, n_parameters) for each effect.
            weights: (robots, n_weights).
            start: batched states, as `settle` gives them.
            steps: control steps, at most `rows`.
            override: readings that controllers get; None: the robots' own.
        """
        return self._rollout(values, weights, start, steps, active=True, override=override)

    def controller(self, values: Values, weights: Any) -> Any:
        """The parameters of one robot's controller, its faults in them."""
        parameters = self.policy.decode(weights, self.interface.n_inputs, self.interface.n_outputs)
        for effect in self.catalogue:
            if isinstance(effect, ControllerFault):
                parameters = effect.damage(self.robot, parameters, values[effect.name])
        return parameters

    @property
    def n_weights(self) -> int:
        """Number of weights of one controller."""
        return self.policy.n_weights(self.interface.n_inputs, self.interface.n_outputs)

    def _rollout(
        self,
        values: Values,
        weights: np.ndarray,
        start: BodyState,
        steps: int,
        *,
        active: bool,
        override: ReadingOverride | None = None,
    ) -> Rollout:
        if not 0 < steps <= self.rows:
            raise ValueError(f"{steps} steps do not fit into 1..{self.rows}")
        lanes = RobotInstance(values, np.asarray(weights, np.float32), start)
        override = (
            None if override is None else ReadingOverride(*(np.asarray(x, np.float32)[:, :steps] for x in override))
        )
        rollout = self._run(lanes, steps, active=active, override=override)
        return rollout._replace(**{k: getattr(rollout, k)[:, :steps] for k in ("readings", "commands", "position")})


@dataclass(frozen=True, eq=False)
class CompiledClosedLoop(ClosedLoopSimulator):
    """Closed loops of robots with MJX's models.

    Attributes:
        on_mjx: the robot and its catalogue of effects.
    """

    on_mjx: MjxModel = field(init=False)

    def __post_init__(self) -> None:
        """Put the robot on MJX.

        Raises:
            InputError: MJX cannot simulate it.
        """
        object.__setattr__(self, "on_mjx", mjx_model(self.robot, self.catalogue))

    @property
    def left_out(self) -> tuple[str, ...]:
        """See `ClosedLoopSimulator`."""
        return reduced_to_mjx(self.robot).left_out

    def _rested(self, values: Values) -> Hidden:
        """See `ClosedLoopSimulator`."""
        model, zeros = self.robot.model, partial(np.zeros, dtype=np.float32)
        qpos, centre = self.robot.home().astype(np.float32), self.interface.ctrl_centre.astype(np.float32)
        now = MjxStepStart(qpos, zeros(model.nv), centre, np.ones(model.nu), model.opt.timestep)
        return jax.vmap(lambda v: self.on_mjx.rested(self.on_mjx.model, v, jax.tree.map(jnp.asarray, now)))(values)


def _size(values: Values) -> int:
    return next(iter(values.values())).shape[0]
