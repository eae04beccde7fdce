"""What an explanation must remove to be called one."""

import numpy as np
import pytest

from estexp_jax.discovery.hypotheses import Hypothesis
from estexp_jax.discovery.selection import Explanation, Selection
from estexp_jax.discovery.slopes import Fit
from estexp_jax.discovery.verdict import verdict
from estexp_jax.physics.effects.changes import Change
from tests.discovery.planted import nominal

FRICTION = Change("coulomb_friction", "shaft", {"T": 0.1})
WEAKER = Change("motor_weakness", "servo", {"loss": 0.1})


def leaving(error: float) -> Explanation:
    """Anything that leaves so many deviations."""
    return Explanation(Fit(Hypothesis((), ()), np.zeros(0), 0.0), np.full(8, error**2 / 8))


@pytest.mark.parametrize(
    ("bent", "chosen", "change", "expected"),
    [
        (20.0, 5.0, FRICTION, "missing_physics"),
        (8.0, 5.0, FRICTION, "unexplained"),  # wrong values remove nearly as much
        (8.0, 2.4, FRICTION, "missing_physics"),  # as good as noise
        (20.0, 12.0, FRICTION, "unexplained"),
        (8.0, 5.0, WEAKER, "parameters"),
    ],
)
def test_a_name_is_given_where_it_removes_most_of_what_wrong_values_leave(
    bent: float, chosen: float, change: Change, expected: str
) -> None:
    selection = Selection(leaving(21.0), leaving(21.0), leaving(bent), (), leaving(chosen))
    assert verdict(nominal("one"), selection, (change,)) == expected
