"""The robot in the world: it takes a controller and returns a recorded trial.

Trials are the scarce resource; `RunState.trials` keeps and counts them. A target is any callable that takes a
`Controller` and returns a `Trial`. The two targets of the package are simulated.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, final, runtime_checkable

import numpy as np

from estexp_jax.physics.effects.changes import Change
from estexp_jax.recovery.control.trial import Controller, Trial
from estexp_jax.recovery.simulator import DamageSimulator


class Target(Protocol):
    """A robot in the world."""

    def __call__(self, controller: Controller) -> Trial:
        """Drive the robot, from rest, for `controller.steps` control steps of `controller.control_step`."""
        ...


@runtime_checkable
class RemoteTarget(Protocol):
    """A robot in the world that somebody else operates, so that each trial is requested first."""

    def perform(self, number: int, controller: Controller, predicted: Trial) -> Trial:
        """Run a trial as `Target` does.

        Args:
            number: of the trial, from 0; the same if it is requested again after an interruption.
            controller: that drives the robot.
            predicted: the trial that the simulator, as diagnosed so far, predicts.
        """
        ...


@runtime_checkable
class FilmedTarget(Protocol):
    """A robot whose motion is known, so that it can be drawn."""

    def motion(self, controller: Controller, rows: Sequence[int]) -> np.ndarray:
        """Configurations (len(rows), nq) of the nominal robot's coordinates at control steps of the same trial."""
        ...


@final
class SameTarget:
    """The simulator itself with damage planted in it: only the damage is unknown.

    Args:
        simulator: its catalogue holds the planted effects.
        planted: the damage; kept as an attribute.
    """

    def __init__(self, simulator: DamageSimulator, planted: Sequence[Change]) -> None:
        self._simulator, self.planted = simulator, tuple(planted)

    def __call__(self, controller: Controller) -> Trial:
        """See `Target`."""
        return self._simulator.trial(self.planted, controller.weights, controller.steps)

    def motion(self, controller: Controller, rows: Sequence[int]) -> np.ndarray:
        """See `FilmedTarget`."""
        return self._simulator.motions([self.planted], controller.weights[None], rows)[0]
