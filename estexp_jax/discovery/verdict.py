"""The verdict: nothing wrong, wrong values, missing physics, or something that no explanation reaches."""

from __future__ import annotations

import numpy as np

from estexp_jax.discovery.hypotheses import TOLERANCE
from estexp_jax.discovery.selection import NOISE, Selection, worth
from estexp_jax.discovery.slopes import Fit
from estexp_jax.estimation.accuracy import gain
from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.model.robot import Robot

ENOUGH = 0.6
"""Share of the excess error on held-out windows that an explanation must remove to be called one."""
_BEYOND = 0.5
"""Share of what wrong values of the model leave that missing physics must remove, too: the rest is told by these."""
QUIET = 2.5
"""Deviations up to which an error that nothing explains is put down to noise that lasts longer than thought."""


def verdict(robot: Robot, selection: Selection, changes: tuple[Change, ...]) -> str:
    """`consistent`, `parameters`, `missing_physics` or `unexplained`.

    Args:
        robot: the nominal robot.
        selection: what was tried and chosen, judged on held-out windows of training recordings.
        changes: the chosen claims with their fitted values.
    """
    if selection.seen:
        return "missing_physics"
    if selection.piled:
        return "unexplained"
    # A robot does not step; but where it was simulated itself, at the same step, there is nothing to correct.
    as_it_is, chosen = min(selection.nominal, selection.corrected, key=lambda e: e.error), selection.chosen
    if as_it_is.error <= NOISE:
        return "consistent"
    if not changes and min(as_it_is.error, chosen.error) <= QUIET and not worth(chosen, as_it_is):
        return "consistent"
    bent = all(is_wrong_value(robot, change) for change in changes)
    said = gain(chosen.error, as_it_is.error, 1.0) >= ENOUGH and (
        bent or gain(chosen.error, selection.parameters.error, 1.0) >= _BEYOND
    )
    if chosen.error > QUIET and not (changes and said):
        return "unexplained"
    return "parameters" if bent else "missing_physics"


def is_wrong_value(robot: Robot, change: Change) -> bool:
    """Whether a change only bends a value that the model already has, by at most 30 %."""
    present, value = _present(robot, change), next(iter(change.parameters.values()))
    return present > 0.0 and abs(value) <= TOLERANCE * present


def _present(robot: Robot, change: Change) -> float:
    """The value of the model that a change bends; 0 where it has none."""
    return effect(change.effect).nominal_value(robot, change.name or "")


def bent_values(robot: Robot, fitted: Fit, intervals: np.ndarray) -> tuple[Change, ...]:
    """Those changes of the model's own values that are worth telling, the relatively largest first.

    More than one per cent, and more than the interval leaves in doubt; at least the largest one.

    Args:
        robot: the nominal robot.
        fitted: the values beside what is claimed.
        intervals: (n_free, 2) of all of them.
    """
    free = zip(fitted.hypothesis.free, intervals, strict=True)
    settled = {(f.effect, f.site) for f, (low, high) in free if low > 0.0 or high < 0.0}
    changes = fitted.hypothesis.changes(fitted.vector, claimed=False)
    ranked = sorted((c for c in changes if _share(robot, c) > 0.01), key=lambda c: _share(robot, c), reverse=True)
    return tuple(c for c in ranked if (c.effect, c.name or "") in settled) or tuple(ranked[:1])


def _share(robot: Robot, change: Change) -> float:
    """By which share of what it is in the model a value is changed."""
    present = _present(robot, change)
    return abs(next(iter(change.parameters.values()))) / present if present > 0.0 else 0.0
