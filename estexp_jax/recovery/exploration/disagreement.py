"""The most informative next trial: the one on which the remaining explanations disagree most.

If the likeliest explanation is right, a trial gives the readings that it predicts. Each alternative, simulated with
these readings as inputs, then has a cost and loses probability accordingly. The most informative controller is the one
that would leave the alternatives the least probability.

Source: Bongard, Zykov and Lipson, Resilient machines through continuous self-modeling (2006): actions on which
candidate models disagree. Here they are chosen among controllers that walk, and readings are replayed, as errors grow
in closed loop.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from estexp_jax.physics.effects.changes import Change
from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.estimation.error_model import SAMPLES, TEMPERATURE, angle_cost, linearise_errors_at, touch_cost
from estexp_jax.recovery.model_error import perturbed_robots
from estexp_jax.recovery.simulator import DamageSimulator

_MEMBERS = 16
_TIE = 0.02
"""Differences of the remaining probability below this do not distinguish controllers."""

AlternativeDamage = tuple[tuple[Change, ...], float]
"""Changes of the nominal model, and the probability of this explanation."""


def remaining_probability(
    simulator: DamageSimulator, settings: Settings, controllers: np.ndarray, explanations: Sequence[AlternativeDamage]
) -> np.ndarray:
    """Share (controllers,) of their probability that the alternatives would keep after a trial of each controller.

    Args:
        simulator: of the robot.
        settings: of the run.
        controllers: (controllers, n_weights).
        explanations: the likeliest first, then at least one alternative.
    """
    damages, n = [changes for changes, _ in explanations], len(explanations)
    steps, touch = min(SAMPLES, settings.steps), simulator.closed_loop.interface.is_touch
    readings = np.asarray(simulator.trials(damages[:1], controllers, steps).readings[0])
    perturbed = [
        (*damages[0], *member) for member in perturbed_robots(simulator.robot, settings.relative_error, _MEMBERS)
    ]
    replayed = np.asarray(simulator.trials([*damages, *perturbed], controllers, steps, readings).readings, float)
    shares = np.array([p for _, p in explanations[1:]])
    remaining = []
    for each in np.moveaxis(replayed, 1, 0)[:, :, None]:  # (sets, one trial, steps, n_inputs)
        first, alternatives = each[0], each[1:n]
        error_model = linearise_errors_at(np.concatenate([each[:1], each[n:]]), touch, np.zeros((_MEMBERS, 0)))
        cost = angle_cost(error_model, (first - alternatives)[..., ~touch].reshape(n - 1, -1))
        cost += touch_cost(error_model, first[..., touch], alternatives[..., touch])
        cost = np.nan_to_num(cost, nan=np.inf)  # a diverged simulation excludes its explanation
        remaining.append(np.sum(shares * np.exp(-cost / (2.0 * TEMPERATURE))) / shares.sum())
    return np.array(remaining)


def most_informative(remaining: np.ndarray) -> int:
    """Index of the first controller whose remaining probability (controllers,) is about the lowest."""
    return int(np.flatnonzero(remaining <= np.min(remaining) + _TIE)[0])
