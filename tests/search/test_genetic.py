"""Laws of the paper's genetic algorithm."""

import numpy as np
import pytest

from estexp_jax.search.driver import evolve
from estexp_jax.search.genetic import Genetic, ask_genetic, begin_genetic, tell_genetic

GENETIC = Genetic(length=12, population=40, seed=3, tags=(1, 2))


def sphere(genomes: np.ndarray) -> np.ndarray:
    return np.sum((genomes - 0.37) ** 2, axis=1)


def test_the_best_half_survives_with_its_scores() -> None:
    before, after = list(evolve(GENETIC, sphere, 6))[-2:]
    survivors = {genome.tobytes() for genome in before.genomes[:20]}
    assert survivors <= {genome.tobytes() for genome in after.genomes}
    assert np.array_equal(np.sort(after.scores), after.scores)
    assert np.array_equal(sphere(after.genomes), after.scores)


def test_the_best_never_gets_worse_and_gets_better() -> None:
    scores = [state.scores[0] for state in evolve(GENETIC, sphere, 30)]
    assert np.all(np.diff(scores) <= 0.0)
    assert scores[-1] < 0.5 * scores[0]


def test_values_are_hundredths_in_range() -> None:
    state = list(evolve(GENETIC, sphere, 10))[-1]
    assert np.all(np.abs(state.genomes) <= 1.0)
    assert np.allclose(100 * state.genomes, np.round(100 * state.genomes), atol=1e-12)


def test_other_seeds_and_tags_give_other_populations() -> None:
    first = ask_genetic(GENETIC, begin_genetic(GENETIC))
    assert not np.array_equal(first, ask_genetic(Genetic(12, 40, 4, (1, 2)), begin_genetic(GENETIC)))
    assert not np.array_equal(first, ask_genetic(Genetic(12, 40, 3, (1, 3)), begin_genetic(GENETIC)))


def test_seeds_take_the_first_places() -> None:
    seed = np.full(12, 0.37)
    state = next(evolve(GENETIC, sphere, 1, seeds=[seed]))
    assert np.array_equal(state.genomes[0], seed)


def test_what_blew_up_is_worst_and_never_best() -> None:
    genomes = ask_genetic(GENETIC, begin_genetic(GENETIC))
    scores = np.full(40, np.nan)
    assert np.all(tell_genetic(GENETIC, begin_genetic(GENETIC), genomes, scores).scores == np.inf)
    scores[7] = 5.0
    after = tell_genetic(GENETIC, begin_genetic(GENETIC), genomes, scores)
    assert after.scores[0] == 5.0 and np.array_equal(after.genomes[0], genomes[7])


def test_dominants_are_new_genomes_better_than_all_before() -> None:
    state = next(evolve(GENETIC, sphere, 1))
    children = ask_genetic(GENETIC, state)
    scores = np.full(20, state.scores[0])
    scores[:3] -= [0.1, 0.2, 0.3]
    assert tell_genetic(GENETIC, state, children, scores).dominants == 3


def test_without_mutation_and_crossover_children_are_copies_of_survivors() -> None:
    genetic = Genetic(12, 40, 3, mutation=0.0, crossover=0.0)
    state = next(evolve(genetic, sphere, 1))
    survivors = {genome.tobytes() for genome in state.genomes[:20]}
    assert {child.tobytes() for child in ask_genetic(genetic, state)} <= survivors


def test_crossover_mixes_values_but_makes_none() -> None:
    genetic = Genetic(12, 40, 3, mutation=0.0)
    state = next(evolve(genetic, sphere, 1))
    survivors, children = state.genomes[:20], ask_genetic(genetic, state)
    assert all(np.isin(children[:, i], survivors[:, i]).all() for i in range(12))
    assert not {child.tobytes() for child in children} <= {genome.tobytes() for genome in survivors}


def test_mutation_draws_one_value_in_a_hundred_anew() -> None:
    genetic = Genetic(2000, 40, 3, crossover=0.0)
    state = next(evolve(genetic, sphere, 1))
    differing = [np.min(np.sum(child != state.genomes[:20], axis=1)) for child in ask_genetic(genetic, state)]
    assert 0.008 < np.mean(differing) / 2000 < 0.012


def test_impossible_settings_are_refused() -> None:
    with pytest.raises(ValueError, match="at least 4"):
        Genetic(12, 2)
    with pytest.raises(ValueError, match="mutation"):
        Genetic(12, 40, mutation=2.0)
