"""The paper's metrics as a cost of hypotheses."""

from dataclasses import replace

from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.estimation.hypothesis_cost import MetricCost
from estexp_jax.recovery.simulator import DamageSimulator
from tests.recovery.estimation.lost_leg import LOST, OpenLoopTrials


def test_commands_that_were_played_open_loop_are_replayed(
    world: DamageSimulator, rough: Settings, open_loop: OpenLoopTrials
) -> None:
    weights, right, wrong = open_loop
    paper = replace(rough, paper=True)
    costs = [MetricCost(world, paper, [weights], [trial]).evaluate(LOST)[0] for trial in (right, wrong)]
    assert costs[0] == 0.0 < costs[1]
