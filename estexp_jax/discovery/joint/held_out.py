"""The held-out rule: an effect stays, or comes in, only where stretches that were not fitted are predicted better.

All about one linearisation: a stretch of the windows is left out, the rest is fitted in closed form with and without an
effect, and the stretch is predicted by both. What a model still lacks differs from stretch to stretch, so that an
effect that stands in for it gains in some and loses in others.

Sources: Vehtari, Gelman and Gabry, Statistics and Computing 27 (2017), the standard error of a difference of held-out
log predictive densities; Lange, Little and Taylor, Journal of the American Statistical Association 84 (1989),
Student's t.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, final

import numpy as np

from estexp_jax.estimation.linearised import Linearised

_RIDGE = 1e-9
"""Precision of a free column, as a share of what the data say of it."""


class HeldOutGain(NamedTuple):
    """What a column, or a group of them, adds to the held-out log predictive density.

    Attributes:
        total: over all stretches, nats.
        standard_error: of it, from how stretches differ.
        coefficient: of the column, fitted to all.
    """

    total: float
    standard_error: float
    coefficient: float

    @property
    def in_errors(self) -> float:
        """The gain in its standard errors."""
        return self.total / max(self.standard_error, 1e-300)


@final
@dataclass(frozen=True, eq=False)
class HeldOut:
    """Normal equations of whitened windows.

    The loss of a window is that of Student's t: how far a model errs differs from window to window, so that a window's
    error counts by its ratio, and none outweighs all others.

    Attributes:
        linear: the windows about a point.
        target: (data,) what the columns are to explain.
        precision: (columns,) of the columns' priors; 0: free.
        stretches: into how many parts the windows are divided.
        data: how many independent data there are in a window.
        freedom: degrees of freedom of Student's t.
    """

    linear: Linearised
    target: np.ndarray
    precision: np.ndarray
    stretches: int
    data: float
    freedom: float

    def gain_of(self, group: Sequence[int] | np.ndarray, base: Sequence[int] | np.ndarray) -> HeldOutGain:
        """What a group of columns adds to a base without it."""
        rest = np.setdiff1d(base, group)
        return _gain(self._losses(rest), self._losses(np.union1d(rest, group)))

    def gains_of(
        self,
        columns: Sequence[int] | np.ndarray,
        base: np.ndarray,
        gone: np.ndarray,
        least: np.ndarray,
        most: np.ndarray,
    ) -> list[HeldOutGain]:
        """What each of some columns adds to a base in place of `gone`; coefficients within bounds (columns,)."""
        before, found = self._losses(base), []
        rest = np.setdiff1d(base, gone)
        fits = [_Solved.of(m, v, rest) for m, v in zip(self._rest, self._rest_vectors, strict=True)]
        whole = _Solved.of(self._whole, self._vectors.sum(axis=0), rest)
        for c, low, high in zip(np.asarray(columns).tolist(), least, most, strict=True):
            at = np.append(rest, c)
            losses = [self._loss(b, at, fit.with_column(c, low, high)) for b, fit in enumerate(fits)]
            found.append(_gain(before, np.array(losses), whole.with_column(c, low, high)[-1]))
        return found

    @cached_property
    def _parts(self) -> list[np.ndarray]:
        """Positions of the windows of each stretch, in ascending order of windows."""
        n = len(np.unique(self.linear.window))
        return np.array_split(np.arange(n), min(self.stretches, n))

    @cached_property
    def _own(self) -> list[np.ndarray]:
        return [self.linear.window == w for w in np.unique(self.linear.window)]

    @cached_property
    def _matrices(self) -> np.ndarray:
        j = self.linear.columns
        return np.array([j[own].T @ j[own] for own in self._own])

    @cached_property
    def _vectors(self) -> np.ndarray:
        return np.array([self.linear.columns[own].T @ self.target[own] for own in self._own])

    @cached_property
    def _squares(self) -> np.ndarray:
        return np.array([np.sum(self.target[own] ** 2) for own in self._own])

    @cached_property
    def _whole(self) -> np.ndarray:
        matrix = self._matrices.sum(axis=0)
        return matrix + np.diag(np.where(self.precision > 0.0, self.precision, _RIDGE * np.diag(matrix) + 1e-300))

    @cached_property
    def _rest(self) -> list[np.ndarray]:
        return [self._whole - self._matrices[part].sum(axis=0) for part in self._parts]

    @cached_property
    def _rest_vectors(self) -> list[np.ndarray]:
        return [self._vectors.sum(axis=0) - self._vectors[part].sum(axis=0) for part in self._parts]

    def _loss(self, stretch: int, columns: np.ndarray, x: np.ndarray) -> float:
        """Of a stretch's windows together, predicted by coefficients of some columns."""
        part = self._parts[stretch]
        own = self._matrices[part][:, columns][:, :, columns]
        squares = self._squares[part] - 2.0 * self._vectors[part][:, columns] @ x + np.einsum("i,wij,j->w", x, own, x)
        logs = np.log1p(np.maximum(squares, 0.0) / self.freedom)
        return float(0.5 * (self.freedom + self.data) * logs.sum())

    def _losses(self, columns: np.ndarray) -> np.ndarray:
        """Of each stretch, predicted by the others' fit."""
        fits = [_Solved.of(m, v, columns) for m, v in zip(self._rest, self._rest_vectors, strict=True)]
        return np.array([self._loss(b, columns, fit.mean) for b, fit in enumerate(fits)])


class _Solved(NamedTuple):
    """Least squares on some columns, to which one may be added.

    Attributes:
        matrix, vector: of all columns.
        base: (k,) the columns solved for.
        inverse: (k, k).
        mean: (k,).
    """

    matrix: np.ndarray
    vector: np.ndarray
    base: np.ndarray
    inverse: np.ndarray
    mean: np.ndarray

    @classmethod
    def of(cls, matrix: np.ndarray, vector: np.ndarray, base: np.ndarray) -> _Solved:
        inverse = np.linalg.inv(matrix[np.ix_(base, base)])
        return cls(matrix, vector, base, inverse, inverse @ vector[base])

    def with_column(self, c: int, low: float, high: float) -> np.ndarray:
        """Coefficients (k + 1,) with one more column, its own last and within bounds."""
        cross = self.inverse @ self.matrix[self.base, c]
        curvature = self.matrix[c, c] - self.matrix[self.base, c] @ cross
        times = (self.vector[c] - self.matrix[self.base, c] @ self.mean) / max(
            curvature, _RIDGE * self.matrix[c, c] + 1e-300
        )
        times = float(np.clip(times, low, high))
        return np.append(self.mean - cross * times, times)


def _gain(before: np.ndarray, after: np.ndarray, coefficient: float = np.nan) -> HeldOutGain:
    each = before - after
    error = np.sqrt(len(each)) * np.std(each, ddof=1) if len(each) > 1 else np.inf
    return HeldOutGain(float(each.sum()), float(error), float(coefficient))
