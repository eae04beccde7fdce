"""The next trial to learn most from: the one on which explanations that are not excluded yet disagree most.

If the likeliest explanation is right, a trial under a controller shows what that one foretells; each rival, replayed
with those readings, is then off by some cost, and loses probability accordingly. The controller that would leave the
rivals least is the most telling one.

Source: Bongard, Zykov and Lipson, Resilient machines through continuous self-modeling (2006): actions on which
candidate models disagree; here among controllers that walk, and under replay, as errors feed on themselves in closed
loop.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from estexp_jax.physics.effects.changes import Change
from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.estimation.error_model import SAMPLES, TEMPER, angle_cost, linearise_errors_at, touch_cost
from estexp_jax.recovery.model_error import perturbed_robots
from estexp_jax.recovery.simulator import DamageSimulator

_MEMBERS = 16
_ALIKE = 0.02
"""Shares left to the rivals that are this near tell controllers no more apart."""

RivalDamage = tuple[tuple[Change, ...], float]
"""What differs, and its probability."""


def remaining_probability(
    simulator: DamageSimulator, settings: Settings, controllers: np.ndarray, explanations: Sequence[RivalDamage]
) -> np.ndarray:
    """Share (controllers,) of the rivals' probability that would be left to them after a trial under each controller.

    Args:
        simulator: of the robot.
        settings: of the run.
        controllers: (controllers, n_weights).
        explanations: the likeliest first, then at least one rival.
    """
    told, n = [changes for changes, _ in explanations], len(explanations)
    steps, touch = min(SAMPLES, settings.steps), simulator.walker.interface.is_touch
    heard = np.asarray(simulator.trials(told[:1], controllers, steps).readings[0])
    off = [(*told[0], *member) for member in perturbed_robots(simulator.robot, settings.rough, _MEMBERS)]
    walk = np.asarray(simulator.trials([*told, *off], controllers, steps, heard).readings, float)
    shares = np.array([p for _, p in explanations[1:]])
    left = []
    for each in np.moveaxis(walk, 1, 0)[:, :, None]:  # (sets, one trial, steps, n_inputs)
        first, rivals = each[0], each[1:n]
        about = linearise_errors_at(np.concatenate([each[:1], each[n:]]), touch, np.zeros((_MEMBERS, 0)))
        cost = angle_cost(about, (first - rivals)[..., ~touch].reshape(n - 1, -1))
        cost += touch_cost(about, first[..., touch], rivals[..., touch])
        cost = np.nan_to_num(cost, nan=np.inf)  # a rival that blows up would be excluded
        left.append(np.sum(shares * np.exp(-cost / (2.0 * TEMPER))) / shares.sum())
    return np.array(left)


def most_informative(left: np.ndarray) -> int:
    """Index of the first controller, in the order given, that leaves the rivals about as little as any does."""
    return int(np.flatnonzero(left <= np.min(left) + _ALIKE)[0])
