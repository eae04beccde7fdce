"""The simulator that both phases use: it takes sets of changes and controllers and returns trials."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import final

import jax
import numpy as np

from estexp_jax.errors import InputError
from estexp_jax.physics.effects.base import CommandShift, ReadingDrift, ReadingShift
from estexp_jax.physics.effects.changes import Change, Values, encode_all
from estexp_jax.physics.effects.controller_fault import ControllerFault
from estexp_jax.physics.effects.registry import catalogue, damages, effect, model_errors, paper
from estexp_jax.physics.engines.choice import closed_loop_simulator
from estexp_jax.physics.engines.closed_loop import (
    BodyState,
    ClosedLoopSimulator,
    ReadingOverride,
    Rollout,
    replace_readings,
)
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.control.network import RecurrentPolicy
from estexp_jax.recovery.control.trial import Controller, Trial


@final
@dataclass(frozen=True, eq=False)
class DamageSimulator:
    """Simulates any damage under any controller with one compiled program.

    Attributes:
        closed_loop: the engine.
        settle_steps: control steps with motors at home before each trial.
        control_step: time between two commands, s.
        gain: of the controllers' neurons.
    """

    closed_loop: ClosedLoopSimulator
    settle_steps: int
    control_step: float
    gain: float

    @property
    def robot(self) -> Robot:
        """The nominal robot."""
        return self.closed_loop.robot

    @property
    def n_weights(self) -> int:
        """Length of a controller's genome."""
        return self.closed_loop.n_weights

    @cached_property
    def finer(self) -> DamageSimulator:
        """The same simulator at half the physics step."""
        return replace(self, closed_loop=self.closed_loop.finer(2))

    def controller(self, weights: np.ndarray, steps: int) -> Controller:
        """The controller of weights (n_weights,), as a robot in the world runs it."""
        return Controller(weights, self.closed_loop.interface, self.gain, self.control_step, steps)

    def settled(self, sets: Sequence[Sequence[Change]]) -> BodyState:
        """States (sets, ...) in which robots with these changes come to rest; their trials start there."""
        return self.closed_loop.settle(self._values(sets), self.settle_steps)

    def rollouts(
        self,
        sets: Sequence[Sequence[Change]],
        start: BodyState,
        weights: np.ndarray,
        steps: int,
        override: ReadingOverride | None = None,
    ) -> Rollout:
        """Simulate every damaged robot under every controller.

        Args:
            sets: the changes of each robot.
            start: initial state of each robot, as of `settled(sets)`.
            weights: (controllers, n_weights).
            steps: control steps.
            override: of the networks' readings, arrays (sets or 1, controllers or 1, steps, n_inputs); None: the
                robots' own readings.

        Returns:
            Arrays (sets, controllers, ...).
        """
        s, c = len(sets), len(weights)
        initial, values = jax.tree.map(lambda x: np.repeat(x, c, axis=0), (start, self._values(sets)))
        many = jax.tree.map(lambda x: np.broadcast_to(x, (s, c, *x.shape[2:])).reshape(s * c, *x.shape[2:]), override)
        rollout = self.closed_loop.rollout(values, np.tile(weights, (s, 1)), initial, steps, many)
        return jax.tree.map(lambda x: x.reshape(s, c, *x.shape[1:]), rollout)

    def trials(
        self, sets: Sequence[Sequence[Change]], weights: np.ndarray, steps: int, readings: np.ndarray | None = None
    ) -> Rollout:
        """`rollouts` from the states in which these robots come to rest.

        With `readings` (controllers, steps, n_inputs), recorded readings drive the networks in place of simulated ones.
        """
        override = None if readings is None else replace_readings(readings[None])
        return self.rollouts(sets, self.settled(sets), weights, steps, override)

    def rollout_each(self, sets: Sequence[Sequence[Change]], weights: np.ndarray, steps: int) -> Rollout:
        """Simulate many damaged robots, each under its own controller.

        Args:
            sets: the changes of each robot.
            weights: (len(sets), n_weights).
            steps: control steps.

        Returns:
            Arrays (sets, ...).
        """
        return self.closed_loop.rollout(self._values(sets), weights, self.settled(sets), steps)

    def motions(self, sets: Sequence[Sequence[Change]], weights: np.ndarray, rows: Sequence[int]) -> np.ndarray:
        """Configurations of many damaged robots, each under its own controller.

        A rollout keeps only its last configuration, so there is one rollout for each row. They equal those of `trial`
        bit for bit.

        Args:
            sets: the changes of each robot.
            weights: (len(sets), n_weights).
            rows: control steps.

        Returns:
            Configurations (sets, rows, nq).
        """
        values, start = self._values(sets), self.settled(sets)
        ends = (self.closed_loop.rollout(values, weights, start, row).final if row else start for row in rows)
        return np.stack([np.asarray(end.qpos) for end in ends], axis=1)

    def trial(self, changes: Sequence[Change], weights: np.ndarray, steps: int) -> Trial:
        """One trial of one damaged robot under one controller (n_weights,)."""
        rollout = self.trials([changes], weights[None], steps)
        time = self.control_step * np.arange(steps)
        return Trial(time, rollout.readings[0, 0], rollout.commands[0, 0], rollout.position[0, 0])

    def _values(self, sets: Sequence[Sequence[Change]]) -> Values:
        return encode_all(self.robot, self.closed_loop.catalogue, sets)


def damage_simulator(robot: Robot, settings: Settings, planted: Sequence[Change] = ()) -> DamageSimulator:
    """The simulator of a run.

    Its catalogue holds the candidates of the estimation, the effects of model error, and the planted effects.

    Raises:
        InputError: a planted effect cannot be simulated in closed loop, or the robot lacks a controller's sensors.
    """
    timed = (CommandShift, ReadingShift, ReadingDrift)
    other = next((c for c in planted if isinstance(effect(c.effect), timed)), None)
    if other is not None:
        raise InputError(f"'{other.effect}' is not simulated in closed loop", where="--damage")
    faults = [e for e in damages() if isinstance(e, ControllerFault)]
    extended = (*damages(), *model_errors()) if settings.catalogue == "full" or settings.relative_error > 0.0 else ()
    names = dict.fromkeys([*(e.name for e in (*paper(), *faults, *extended)), *(c.effect for c in planted)])
    engine = closed_loop_simulator(
        robot,
        catalogue(names),
        policy=RecurrentPolicy(settings.gain),
        rows=max(settings.steps, settings.settle_steps, settings.samples),
        control_step=settings.control_step,
        population=settings.population,
        engine=settings.engine,
    )
    return DamageSimulator(engine, settings.settle_steps, settings.control_step, settings.gain)
