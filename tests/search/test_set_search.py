"""Laws of the set search, on residuals that are plain functions."""

from collections.abc import Callable

import numpy as np
import pytest

from estexp_jax.search.set_moves import Option, OptionSet
from estexp_jax.search.set_search import (
    SetSearch,
    SetSearchState,
    ask_set_search,
    begin_set_search,
    done,
    set_probabilities,
    tell_set_search,
)

OPTIONS = (Option(1.0, 1.0, (1.0,)), *(Option(0.0, 1.0, (0.2, 0.4, 0.7, 1.0)) for _ in range(5)))
SEARCH = SetSearch(OPTIONS)


def world(truth: dict[int, float], error: float = 0.0) -> Callable[[OptionSet], float]:
    """Mean absolute difference of amounts: each option acts on a sensor of its own."""
    return lambda items: (
        error + float(np.mean([abs(dict(items).get(i, 0.0) - truth.get(i, 0.0)) for i in range(len(OPTIONS))]))
    )


def search(
    residual: Callable[[OptionSet], float], state: SetSearchState | None = None, seeds: tuple[OptionSet, ...] = ()
) -> list[SetSearchState]:
    states = [begin_set_search() if state is None else state]
    while not done(states[-1]):
        asked = ask_set_search(SEARCH, states[-1], seeds)
        states.append(tell_set_search(SEARCH, states[-1], asked, [residual(items) for items in asked]))
    return states


@pytest.mark.parametrize(
    "truth", [{}, {0: 1.0}, {3: 0.53}, {0: 1.0, 2: 0.5}, {1: 0.9, 4: 0.31}, {0: 1.0, 1: 0.5, 5: 0.5}]
)
def test_the_truth_is_found_to_the_percent(truth: dict[int, float]) -> None:
    found = search(world(truth))[-1].pool[0]
    assert dict(found.items) == pytest.approx(truth, abs=1e-6)


def test_errors_of_the_simulator_are_not_explained_away() -> None:
    found = search(world({2: 0.5, 4: 0.02}, error=0.05))[-1].pool[0]
    assert [index for index, _ in found.items] == [2]


def test_going_on_from_any_round_gives_the_same() -> None:
    residual = world({1: 0.9, 4: 0.31})
    states = search(residual)
    for state in states[1:-1:3]:
        assert search(residual, SetSearchState.from_tree(state.to_tree()))[-1] == states[-1]


def test_a_seed_that_explains_everything_ends_the_search_at_once() -> None:
    states = search(world({1: 0.33, 4: 0.31}), seeds=(((1, 0.33), (4, 0.31)),))
    assert [state.stage for state in states] == ["coarse", "prune", "done"]


def test_what_blew_up_is_never_best() -> None:
    found = search(lambda items: np.nan if items else 0.3)[-1].pool[0]
    assert found.items == ()


def test_probabilities_sum_to_one_and_fall() -> None:
    shares = set_probabilities(SEARCH, search(world({2: 0.5}))[-1], 4.0)
    assert shares.sum() == pytest.approx(1.0)
    assert np.all(np.diff(shares) <= 0.0)
