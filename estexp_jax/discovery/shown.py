"""What simulators say of all windows, replayed once for every figure that is drawn from it."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.slopes import Fit

NOMINAL = "nominal"
"""It runs at its own step."""


@final
@dataclass(frozen=True, eq=False)
class Shown:
    """Simulators beside recordings.

    Attributes:
        problem: the comparison as the results show it.
        readings: of each simulator (windows, rows, channels), NaN beyond a window's end.
    """

    problem: Problem
    readings: Mapping[str, np.ndarray]

    def of(self, name: str, windows: np.ndarray) -> np.ndarray:
        """Readings (windows, rows, channels) in some windows, as many rows as the longest of them has."""
        return self.readings[name][windows, : max(self.problem.segments[w].rows for w in windows)]

    def error(self, name: str, windows: np.ndarray) -> float:
        """The nrmse on some windows."""
        return self.problem.recorded.error_of(self.of(name, windows), windows)

    def costs(self, name: str, windows: np.ndarray) -> np.ndarray:
        """Mean squared errors over squared ranges (windows,)."""
        return np.nanmean(self.problem.recorded.shares_of(self.of(name, windows), windows), axis=(1, 2))

    def joined(self, name: str, recording: int) -> np.ndarray:
        """Readings (rows, channels) of one recording, its windows one after the other."""
        windows = self.problem.windows_of([recording])
        parts = zip(self.of(name, windows), windows, strict=True)
        return np.concatenate([part[: self.problem.segments[w].rows] for part, w in parts])


def shown_by(problem: Problem, fits: Mapping[str, Fit], stepped: Collection[str] = (NOMINAL,)) -> Shown:
    """Replay fits in all windows.

    Args:
        problem: the comparison as the results show it.
        fits: by name; `nominal` is one.
        stepped: those that are the nominal simulator at its own step; all others run at the finest one.
    """
    own, exact = replace(problem, step=None), problem.exact()
    windows, others = np.arange(len(problem.segments)), [name for name in fits if name not in stepped]
    [nominal] = own.simulated([fits[NOMINAL].member], windows)
    found = exact.simulated([fits[name].member for name in others], windows) if others else []
    names, readings = (*stepped, *others), [*[nominal] * len(stepped), *found]
    return Shown(problem, dict(zip(names, readings, strict=True)))
