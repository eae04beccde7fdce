"""What a search asks before it goes on."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from estexp_jax.discovery.hypotheses import Hypothesis
from estexp_jax.discovery.searching import _added, _Found, _goes_on, _Search
from estexp_jax.discovery.selection import Explanation
from estexp_jax.discovery.slopes import Fit


def problem(steps: int, joints: int = 1) -> Any:
    robot = SimpleNamespace(model=SimpleNamespace(nv=joints))
    return SimpleNamespace(counted=[steps], replayer=SimpleNamespace(robot=robot))


def explanation(error: float) -> Explanation:
    return Explanation(Fit(Hypothesis((), ()), np.zeros(0), error**2), np.full(4, error**2 / 4.0))


def test_more_effects_are_looked_for_where_some_explain_and_it_is_not_too_long() -> None:
    much, little = explanation(8.0), explanation(15.0)
    nominal = explanation(30.0)
    assert _goes_on(problem(10**8), much, nominal)
    assert not _goes_on(problem(10**8), little, nominal)
    assert not _goes_on(problem(10**9), much, nominal)
    assert not _goes_on(problem(2 * 10**8, joints=6), much, nominal)


def test_a_search_ends_where_everything_is_claimed() -> None:
    """`--effects` may name fewer effects than would explain all."""
    place = ("viscous_friction", "elbow")
    there = problem(0)
    there.places = (place,)
    best = explanation(4.0)
    fitted = Fit(Hypothesis((place,), ()), np.zeros(0), 16.0)
    steps = _added(_Search(Hypothesis((), ()), []), _Found(there, best, ()), [fitted], 2)
    with pytest.raises(StopIteration) as end:
        next(steps)
    assert end.value.value.chosen is best
