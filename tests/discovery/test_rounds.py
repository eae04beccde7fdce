"""Which windows a rough fit looks at."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from estexp_jax.discovery.rounds import every_second


def problem(owners: list[int]) -> Any:
    return SimpleNamespace(
        segments=[SimpleNamespace(recording=owner) for owner in owners], fitted=np.arange(len(owners))
    )


def test_every_second_window_is_of_all_parts_of_motions() -> None:
    """Of recordings with two windows each: the first of one, the second of the next."""
    assert every_second(problem([3, 3, 5, 5, 8, 8])).tolist() == [0, 3, 4]
    assert every_second(problem([1] * 5 + [2] * 4)).tolist() == [0, 2, 4, 6, 8]
