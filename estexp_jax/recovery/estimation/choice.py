"""Choice of a run's estimation method and of its cost."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.control.trial import Trial
from estexp_jax.recovery.estimation.hypothesis_cost import HypothesisCost, MetricCost
from estexp_jax.recovery.estimation.likelihood import EnsembleLikelihood
from estexp_jax.recovery.estimation.method import Estimation
from estexp_jax.recovery.estimation.paper_estimation import PaperEstimation
from estexp_jax.recovery.estimation.replay_estimation import ReplayEstimation
from estexp_jax.recovery.estimation.set_estimation import SetEstimation
from estexp_jax.recovery.simulator import DamageSimulator


def estimation_of(simulator: DamageSimulator, settings: Settings, number: int) -> Estimation:
    """The estimation method of pass `number`, counted from 1."""
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
    """The cost of hypotheses on all trials so far.

    Args:
        simulator: of the robot.
        settings: of the run.
        controllers: (n_weights,) each, one for each trial.
        trials: of the damaged robot.
        healthy: controllers and trials before the damage; used for simulators with errors only.
    """
    if _replays(settings):
        return EnsembleLikelihood(simulator, settings, controllers, trials, healthy)
    return MetricCost(simulator, settings, controllers, trials)


def _replays(settings: Settings) -> bool:
    return not settings.paper and settings.relative_error > 0.0 and settings.metric == "rolling-mean"
