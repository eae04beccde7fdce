"""The robot in the world: a controller goes in, a recorded trial comes out.

Trials are what is scarce: `RunState.trials` keeps them, and so counts them. Any callable that takes a `Controller` and
returns a `Trial` will do; the two kinds that come with the package are simulated.
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
    """A robot in the world that somebody else moves, and that may first have to be asked for."""

    def perform(self, number: int, controller: Controller, predicted: Trial) -> Trial:
        """Have the robot driven as `Target` says.

        Args:
            number: of the trial, from 0; asked for again after an interruption, a trial has the same number.
            controller: that drives it.
            predicted: what the simulator, as diagnosed so far, does under it.
        """
        ...


@runtime_checkable
class FilmedTarget(Protocol):
    """A robot that can also tell how it moved, to be shown."""

    def motion(self, controller: Controller, rows: Sequence[int]) -> np.ndarray:
        """Configurations (len(rows), nq), as the nominal robot numbers them, at control steps of the same trial."""
        ...


@final
class SameTarget:
    """The simulator itself with damage planted in it: nothing but the damage is unknown.

    Args:
        simulator: its catalogue holds the planted effects.
        planted: what differs; kept.
    """

    def __init__(self, simulator: DamageSimulator, planted: Sequence[Change]) -> None:
        self._simulator, self.planted = simulator, tuple(planted)

    def __call__(self, controller: Controller) -> Trial:
        """See `Target`."""
        return self._simulator.trial(self.planted, controller.weights, controller.steps)

    def motion(self, controller: Controller, rows: Sequence[int]) -> np.ndarray:
        """See `FilmedTarget`."""
        return self._simulator.motions([self.planted], controller.weights[None], rows)[0]
