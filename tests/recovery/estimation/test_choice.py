"""Which method and which cost belong to which settings."""

from dataclasses import replace

import pytest

from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.estimation.choice import estimation_of, hypothesis_cost_of
from estexp_jax.recovery.estimation.hypothesis_cost import HypothesisCost, MetricCost
from estexp_jax.recovery.estimation.likelihood import EnsembleLikelihood
from estexp_jax.recovery.estimation.method import Estimation
from estexp_jax.recovery.estimation.paper_estimation import PaperEstimation
from estexp_jax.recovery.estimation.replay_estimation import ReplayEstimation
from estexp_jax.recovery.estimation.set_estimation import SetEstimation
from estexp_jax.recovery.simulator import DamageSimulator
from tests.recovery.estimation.lost_leg import OpenLoopTrials


@pytest.mark.parametrize(
    ("choices", "method", "cost"),
    [
        ({}, SetEstimation, MetricCost),
        ({"paper": True, "model_error": 0.03}, PaperEstimation, MetricCost),
        ({"model_error": 0.03}, ReplayEstimation, EnsembleLikelihood),
        ({"model_error": 0.03, "metric": "distance"}, SetEstimation, MetricCost),
    ],
    ids=["exact", "paper", "with errors", "distance"],
)
def test_settings_choose_method_and_cost(
    choices: dict,
    method: type[Estimation],
    cost: type[HypothesisCost],
    world: DamageSimulator,
    settings: Settings,
    open_loop: OpenLoopTrials,
) -> None:
    chosen = replace(settings, **choices)
    assert type(estimation_of(world, chosen, 1)) is method
    assert type(hypothesis_cost_of(world, chosen, [open_loop.weights], [open_loop.right])) is cost
