"""Neighbours of hypotheses."""

import numpy as np

from estexp_jax.search.set_moves import Option, around, grown, pruned, rounded, scanned, swapped

LOST, LOWER, WEAK = Option(1.0, 1.0, (1.0,)), Option(1.0, 1.0, (1.0,)), Option(0.0, 1.0, (0.2, 0.7))
OPTIONS = (LOST, LOWER, WEAK)
PAIR = ((0, 1.0), (2, 0.5))


def test_a_grown_hypothesis_has_one_more_member_in_order() -> None:
    assert grown(OPTIONS, ()) == [((0, 1.0),), ((1, 1.0),), ((2, 0.2),), ((2, 0.7),)]
    assert grown(OPTIONS, ((1, 1.0),)) == [((0, 1.0), (1, 1.0)), ((1, 1.0), (2, 0.2)), ((1, 1.0), (2, 0.7))]


def test_a_pruned_hypothesis_has_one_member_less() -> None:
    assert pruned([PAIR, ()]) == [((2, 0.5),), ((0, 1.0),)]


def test_only_members_of_fixed_amount_are_swapped() -> None:
    assert swapped(OPTIONS, [PAIR]) == [((1, 1.0), (2, 0.5))]


def test_steps_stay_within_the_range_and_move_one_amount() -> None:
    found = around(OPTIONS, [((0, 1.0), (2, 0.9))], 0.05)
    assert [items[0] for items in found] == [(0, 1.0)] * 6
    np.testing.assert_allclose([items[1][1] for items in found], [0.7, 0.75, 0.8, 0.85, 0.95, 1.0])


def test_a_scan_tries_every_percent() -> None:
    assert [items[0][1] for items in scanned(OPTIONS, [((2, 0.123),)])] == [p / 100 for p in range(101)]


def test_amounts_are_rounded_together_and_alone() -> None:
    pair = ((0, 1.0), (2, 0.503))
    assert rounded([pair]) == [PAIR, pair, PAIR]
