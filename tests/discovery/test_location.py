"""Places, and which of them comes first."""

import numpy as np
import pytest

from estexp_jax.discovery.hypotheses import Hypothesis
from estexp_jax.discovery.location import where
from estexp_jax.discovery.selection import Explanation, Selection
from estexp_jax.discovery.slopes import Fit
from tests.discovery.planted import nominal


def explanation(held_out: float, *places: tuple[str, str]) -> Explanation:
    return Explanation(Fit(Hypothesis(places, ()), np.zeros(0), 0.0), np.full(8, held_out / 8.0))


@pytest.mark.parametrize(("left", "first"), [(95.0, "shoulder"), (50.0, "*")])
def test_of_near_ties_the_claimed_place_comes_first(left: float, first: str) -> None:
    own = explanation(1000.0)
    one = explanation(100.0, ("motor_weakness", "hip"))
    every = explanation(left, ("motor_weakness", "*"))
    other = explanation(500.0, ("viscous_friction", "elbow"))
    found = where(nominal("two"), Selection(own, own, own, (every, one, other), one))
    assert [entry["name"] for entry in found][0] == first
    assert {entry["name"] for entry in found} == {"shoulder", "*", "elbow"}
    shares = [entry["share"] for entry in found[1:]]
    assert shares == sorted(shares, reverse=True) and sum(e["share"] for e in found) == pytest.approx(1.0)
