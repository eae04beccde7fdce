"""Which estimation a run uses, and what it judges hypotheses by."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.control.trial import Trial
from estexp_jax.recovery.estimation.base import Estimation, HypothesisCost, MetricCost
from estexp_jax.recovery.estimation.likelihood import EnsembleLikelihood
from estexp_jax.recovery.estimation.paper import PaperEstimation
from estexp_jax.recovery.estimation.replay import ReplayEstimation
from estexp_jax.recovery.estimation.set import SetEstimation
from estexp_jax.recovery.simulator import DamageSimulator


def estimation_of(simulator: DamageSimulator, settings: Settings, number: int) -> Estimation:
    """The estimation of one pass, counted from 1."""
    if settings.paper:
        return PaperEstimation(simulator, settings, number)
    return ReplayEstimation(simulator, settings, number) if _replays(settings) else SetEstimation(simulator, settings)


def hypothesis_cost_of(
    simulator: DamageSimulator,
    settings: Settings,
    controllers: Sequence[np.ndarray],
    trials: Sequence[Trial],
    healthy: Sequence[tuple[np.ndarray, Trial]] = (),
) -> HypothesisCost:
    """What hypotheses are judged by: all trials so far.

    Args:
        simulator: of the robot.
        settings: of the run.
        controllers: (n_weights,) each, as many as trials.
        trials: what the damaged robot did under them.
        healthy: controllers and trials before the damage; only a rough simulator needs them.
    """
    if _replays(settings):
        return EnsembleLikelihood(simulator, settings, controllers, trials, healthy)
    return MetricCost(simulator, settings, controllers, trials)


def _replays(settings: Settings) -> bool:
    return not settings.paper and settings.rough > 0.0 and settings.metric == "rolling-mean"
