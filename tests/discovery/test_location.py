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


@pytest.mark.parametrize(
    ("claimed", "left", "first"), [(100.0, 95.0, "shoulder"), (100.0, 50.0, "*"), (1.0, 0.5, "shoulder")]
)
def test_of_near_ties_and_within_noise_the_claimed_place_comes_first(claimed: float, left: float, first: str) -> None:
    own = explanation(10.0 * claimed)
    one = explanation(claimed, ("motor_weakness", "hip"))
    every = explanation(left, ("motor_weakness", "*"))
    other = explanation(5.0 * claimed, ("viscous_friction", "elbow"))
    found = where(nominal("two"), Selection(own, own, own, (every, one, other), one))
    assert [entry["name"] for entry in found][0] == first
    assert {entry["name"] for entry in found} == {"shoulder", "*", "elbow"}
    shares = [entry["share"] for entry in found[1:]]
    assert shares == sorted(shares, reverse=True) and sum(e["share"] for e in found) == pytest.approx(1.0)
