"""A window that is thrown far off when it is held out counts only so much, if it is alone."""

import numpy as np

from estexp_jax.discovery.cross_validation import bounded, shortest

NOISE = np.full(20, 0.05)


def test_a_single_window_that_hangs_on_a_hair_is_bounded() -> None:
    held = NOISE.copy()
    held[7] = 260.0
    found = bounded(held, NOISE)
    assert found[7] == 9.0 * 0.05
    np.testing.assert_array_equal(np.delete(found, 7), np.delete(held, 7))


def test_what_predicts_many_windows_badly_is_not_spared() -> None:
    held = NOISE.copy()
    held[:4] = 5.0
    np.testing.assert_array_equal(bounded(held, NOISE), held)
    few = np.array([0.2, 0.2, 0.2, 40.0])
    np.testing.assert_array_equal(bounded(few, np.full(4, 0.25)), few)


def test_a_window_that_no_fit_explains_counts_in_full() -> None:
    fitted = NOISE.copy()
    fitted[3] = 12.0
    held = 1.1 * fitted
    np.testing.assert_array_equal(bounded(held, fitted), held)


def test_of_steps_that_fit_alike_the_shortest_is_taken() -> None:
    """Seen: a motor that fades; where a fold left out what warms it, the longest step was 10 times as far off there."""
    assert shortest([0.1979, 0.1980, 0.1982, 0.2166]) == 2
    assert shortest([0.1979, 0.2015, 0.2050, 0.2166]) == 0
