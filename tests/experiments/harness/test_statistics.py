"""The few statistics that studies report."""

import pytest

from experiments.harness.statistics import holm, share, signed_rank


def test_they_are_those_of_the_books() -> None:
    assert holm([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])
    assert signed_rank([float(i) for i in range(1, 11)], [0.0] * 10) == pytest.approx(2.0**-10)
    assert signed_rank([1.0, 1.0], [1.0, 1.0]) == 1.0
    low, high = share(9, 10)
    assert 0.6 < low < 0.9 < high < 1.0
