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


def test_chance_counts_how_many_were_tried_and_wants_five_windows() -> None:
    def told(windows: int) -> list[float | None]:
        def some(held_out: float, *places: tuple[str, str]) -> Explanation:
            return Explanation(Fit(Hypothesis(places, ()), np.zeros(0), 0.0), held_out * np.linspace(1.0, 2.0, windows))

        base, one, other = some(9.0), some(1.0, ("motor_weakness", "hip")), some(5.0, ("viscous_friction", "elbow"))
        return [entry["p_value"] for entry in where(nominal("two"), Selection(base, base, base, (one, other), one))]

    assert told(8) == pytest.approx([2.0 * 2.0**-8] * 2) and told(4) == [None, None]
