"""The robot's simulator as both phases use it: sets of changes and controllers in, trials out."""

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
from estexp_jax.physics.effects.registry import catalogue, damages, effect, paper
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
from estexp_jax.recovery.control.trial import Controller, Trial
from estexp_jax.recovery.model_error import model_errors


@final
@dataclass(frozen=True, eq=False)
class DamageSimulator:
    """Simulates any damage on any controller, with one executable.

    Attributes:
        walker: the engine.
        settle_steps: control steps with motors at home before each trial.
        control_step: s.
    """

    walker: ClosedLoopSimulator
    settle_steps: int
    control_step: float

    @property
    def robot(self) -> Robot:
        """The nominal robot."""
        return self.walker.robot

    @property
    def n_weights(self) -> int:
        """Length of a controller's genome."""
        return self.walker.n_weights

    @cached_property
    def finer(self) -> DamageSimulator:
        """The same one at half the physics step."""
        return replace(self, walker=self.walker.finer(2))

    def controller(self, weights: np.ndarray, steps: int) -> Controller:
        """A controller (n_weights,) as a robot in the world runs it."""
        return Controller(weights, self.walker.interface, self.walker.gain, self.control_step, steps)

    def settled(self, sets: Sequence[Sequence[Change]]) -> BodyState:
        """Where robots with these changes come to rest: what each trial of theirs starts from, (sets, ...)."""
        return self.walker.settle(self._values(sets), self.settle_steps)

    def walks(
        self,
        sets: Sequence[Sequence[Change]],
        start: BodyState,
        weights: np.ndarray,
        steps: int,
        heard: ReadingOverride | None = None,
    ) -> Rollout:
        """Many damaged robots, each under the same few controllers.

        Args:
            sets: the changes of each robot.
            start: of each robot: `settled(sets)`.
            weights: (controllers, n_weights).
            steps: control steps.
            heard: what the networks get, arrays (sets or 1, controllers or 1, steps, n_inputs); None: the robots' own
                readings.

        Returns:
            Arrays (sets, controllers, ...).
        """
        s, c = len(sets), len(weights)
        starts, values = jax.tree.map(lambda x: np.repeat(x, c, axis=0), (start, self._values(sets)))
        many = jax.tree.map(lambda x: np.broadcast_to(x, (s, c, *x.shape[2:])).reshape(s * c, *x.shape[2:]), heard)
        walk = self.walker.walk(values, np.tile(weights, (s, 1)), starts, steps, many)
        return jax.tree.map(lambda x: x.reshape(s, c, *x.shape[1:]), walk)

    def trials(
        self, sets: Sequence[Sequence[Change]], weights: np.ndarray, steps: int, readings: np.ndarray | None = None
    ) -> Rollout:
        """`walks` from where these robots come to rest.

        Recorded readings (controllers, steps, n_inputs) may drive the networks in place of the simulated ones.
        """
        heard = None if readings is None else replace_readings(readings[None])
        return self.walks(sets, self.settled(sets), weights, steps, heard)

    def each(self, sets: Sequence[Sequence[Change]], weights: np.ndarray, steps: int) -> Rollout:
        """Many damaged robots, each under its own controller.

        Args:
            sets: the changes of each robot.
            weights: (len(sets), n_weights).
            steps: control steps.
        """
        return self.walker.walk(self._values(sets), weights, self.settled(sets), steps)

    def motions(self, sets: Sequence[Sequence[Change]], weights: np.ndarray, rows: Sequence[int]) -> np.ndarray:
        """How many damaged robots move, each under its own controller.

        A walk keeps only its last posture, so there is a walk as long as that for each row. They are the very walks of
        `trial` to the last bit.

        Args:
            sets: the changes of each robot.
            weights: (len(sets), n_weights).
            rows: control steps.

        Returns:
            Configurations (sets, rows, nq).
        """
        values, start = self._values(sets), self.settled(sets)
        ends = (self.walker.walk(values, weights, start, row).final if row else start for row in rows)
        return np.stack([np.asarray(end.qpos) for end in ends], axis=1)

    def trial(self, changes: Sequence[Change], weights: np.ndarray, steps: int) -> Trial:
        """One trial of one damaged robot."""
        walk = self.trials([changes], weights[None], steps)
        time = self.control_step * np.arange(steps)
        return Trial(time, walk.readings[0, 0], walk.commands[0, 0], walk.position[0, 0])

    def _values(self, sets: Sequence[Sequence[Change]]) -> Values:
        return encode_all(self.robot, self.walker.catalogue, sets)


def damage_simulator(robot: Robot, settings: Settings, planted: Sequence[Change] = ()) -> DamageSimulator:
    """The simulator of a run.

    Its catalogue holds all that an estimation may choose from, what the simulator's own errors are made of, and what
    else is planted.

    Raises:
        InputError: a planted effect has no place in closed loop, or the robot has no controller's senses.
    """
    timed = (CommandShift, ReadingShift, ReadingDrift)
    other = next((c for c in planted if isinstance(effect(c.effect), timed)), None)
    if other is not None:
        raise InputError(f"'{other.effect}' is not simulated in closed loop", where="--damage")
    faults = [e for e in damages() if isinstance(e, ControllerFault)]
    extended = (*damages(), *model_errors()) if settings.catalogue == "full" or settings.rough > 0.0 else ()
    names = dict.fromkeys([*(e.name for e in (*paper(), *faults, *extended)), *(c.effect for c in planted)])
    engine = closed_loop_simulator(
        robot,
        catalogue(names),
        rows=max(settings.steps, settings.settle_steps, settings.samples),
        control_step=settings.control_step,
        gain=settings.gain,
        population=settings.population,
        engine=settings.engine,
    )
    return DamageSimulator(engine, settings.settle_steps, settings.control_step)
