"""The set search for exact simulators, on costs that need no simulation."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.estimation.damage_sites import DamageSite
from estexp_jax.recovery.estimation.genome import DamageHypothesis
from estexp_jax.recovery.estimation.method import DamageDiagnosis
from estexp_jax.recovery.estimation.set_estimation import SetEstimation
from estexp_jax.recovery.simulator import DamageSimulator

WEAK = (DamageSite("motor_weakness", "knee_f"), 0.4)
LOST = (DamageSite("part_lost", "upper_b"), 1.0)
BIASED = (DamageSite("sensor_bias", "angle_l"), 0.3)


class Truth:
    """Mean error of amounts, each site with a sensor of its own; `error` is what no hypothesis removes."""

    def __init__(self, *items: tuple[DamageSite, float], error: float = 0.0) -> None:
        self.items, self.error = dict(items), error

    def __call__(self, hypotheses: Sequence[DamageHypothesis], reference: DamageHypothesis = ()) -> np.ndarray:
        return np.array([self.error + self._off(dict(items)) for items in hypotheses])

    def evaluate(self, hypothesis: DamageHypothesis, *, thorough: bool = False) -> tuple[float, float]:
        return float(self([hypothesis])[0]), 1.0

    def _off(self, items: dict[DamageSite, float]) -> float:
        sites = {*items, *self.items}
        return sum(abs(items.get(site, 0.0) - self.items.get(site, 0.0)) for site in sites) / 20.0


def diagnosis(world: DamageSimulator, settings: Settings, truth: Truth) -> DamageDiagnosis:
    method = SetEstimation(world, settings)
    state = method.begin([])
    while not method.done(state):
        state = method.advance(state, truth)
    return method.diagnosis(state)


@pytest.mark.parametrize("items", [(), (WEAK,), (BIASED,), (LOST, WEAK), (BIASED, WEAK)], ids=str)
def test_the_damage_is_found_in_the_catalogue_that_holds_it(
    items: tuple, world: DamageSimulator, settings: Settings
) -> None:
    found = diagnosis(world, settings, Truth(*items))
    assert dict(found.items) == pytest.approx(dict(items), abs=1e-6)
    assert found.alarm is False and found.probability is not None and found.probability > 0.5


def test_what_no_hypothesis_reproduces_raises_the_alarm(world: DamageSimulator, settings: Settings) -> None:
    assert diagnosis(world, settings, Truth(WEAK, error=0.01)).alarm is True


def test_the_papers_catalogue_has_no_bias(world: DamageSimulator, settings: Settings) -> None:
    found = diagnosis(world, replace(settings, catalogue="paper"), Truth(BIASED))
    assert all(site.effect != "sensor_bias" for site, _ in found.items) and found.alarm is True
