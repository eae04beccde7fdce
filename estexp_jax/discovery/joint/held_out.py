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
from scipy import stats

from estexp_jax.estimation.linearised import Linearised

_RIDGE = 1e-9
"""Precision of a free column, as a share of what the data say of it."""


class HeldOutGain(NamedTuple):
    """What a column, or a group of them, adds to the held-out log predictive density.

    Attributes:
        total: over all stretches, nats.
        standard_error: of it, from how stretches differ.
        coefficient: of the column, fitted to all.
        stretches: that differ.
    """

    total: float
    standard_error: float
    coefficient: float
    stretches: int

    @property
    def in_errors(self) -> float:
        """The gain in its standard errors."""
        return self.total / max(self.standard_error, 1e-300)

    def least(self, chance: float) -> float:
        """What the gain exceeds but for a chance, one-sided, by Student's t, since stretches are few."""
        return self.total - float(stats.t.isf(chance, max(self.stretches - 1, 1))) * self.standard_error


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
        c, before = np.asarray(columns, dtype=int), self._losses(base)
        rest = np.setdiff1d(base, gone)
        after = np.array([self._with_each(part, rest, c, least, most) for part in self._parts])
        times = self._fitted(np.zeros(0, int), rest).with_each(c, least, most)[0]
        return [_gain(before, own, t) for own, t in zip(after.T, times, strict=True)]

    @cached_property
    def _parts(self) -> list[np.ndarray]:
        """Positions of the windows of each stretch, in ascending order of windows."""
        n = len(np.unique(self.linear.window))
        return np.array_split(np.arange(n), min(self.stretches, n))

    @cached_property
    def _own(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Columns (data, n) and target (data,) of each window."""
        each = [self.linear.window == w for w in np.unique(self.linear.window)]
        return [(self.linear.columns[own], self.target[own]) for own in each]

    @cached_property
    def _vectors(self) -> np.ndarray:
        return np.array([j.T @ r for j, r in self._own])

    @cached_property
    def _squares(self) -> np.ndarray:
        return np.array([r @ r for _, r in self._own])

    @cached_property
    def _diagonals(self) -> np.ndarray:
        return np.array([np.einsum("dn,dn->n", j, j) for j, _ in self._own])

    @cached_property
    def _prior(self) -> np.ndarray:
        return np.where(self.precision > 0.0, self.precision, _RIDGE * self._diagonals.sum(axis=0) + 1e-300)

    @cached_property
    def _known_rows(self) -> dict[int, np.ndarray]:
        return {}

    @cached_property
    def _last_base(self) -> list[tuple[tuple[int, ...], np.ndarray, np.ndarray]]:
        return []

    def _rows(self, base: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rows (windows, k, n) of each window's normal matrix, and their sum; few are ever needed of the many."""
        asked, last = tuple(base.tolist()), self._last_base
        if not last or last[0][0] != asked:
            known = self._known_rows
            if missing := [c for c in asked if c not in known]:
                found = np.array([j[:, missing].T @ j for j, _ in self._own])
                known.update(zip(missing, np.moveaxis(found, 1, 0), strict=True))
            empty = np.zeros((len(self._own), 0, self.linear.columns.shape[1]))
            rows = np.stack([known[c] for c in asked], axis=1) if asked else empty
            last[:] = [(asked, rows, rows.sum(axis=0))]
        return last[0][1:]

    def _fitted(self, left_out: np.ndarray, base: np.ndarray) -> _Fitted:
        """The fit of a base (k,) to all windows but some."""
        each, total = self._rows(base)
        rows = total - each[left_out].sum(axis=0)
        rows[np.arange(len(base)), base] += self._prior[base]
        kept = np.setdiff1d(np.arange(len(self._own)), left_out)
        vector, diagonal = self._vectors[kept].sum(axis=0), self._diagonals[kept].sum(axis=0) + self._prior
        inverse = np.linalg.inv(rows[:, base])
        return _Fitted(rows, vector, diagonal, inverse, inverse @ vector[base])

    def _losses(self, base: np.ndarray) -> np.ndarray:
        """Of each stretch, predicted by the others' fit."""
        return np.array([self._loss(self._errors(part, base, self._fitted(part, base).mean)) for part in self._parts])

    def _errors(self, part: np.ndarray, base: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Sum of squares (windows,) that coefficients (k,) of a base leave in each window of a stretch."""
        own = self._rows(base)[0][part][:, :, base]
        return self._squares[part] - 2.0 * self._vectors[part][:, base] @ x + (own @ x) @ x

    def _with_each(
        self, part: np.ndarray, base: np.ndarray, c: np.ndarray, least: np.ndarray, most: np.ndarray
    ) -> np.ndarray:
        """Loss (columns,) of a stretch, predicted by the others' fit of a base with each of some columns beside it."""
        fit = self._fitted(part, base)
        times, cross = fit.with_each(c, least, most)
        rows, v = self._rows(base)[0][part], self._vectors[part]
        own, others, m = rows[:, :, base], rows[:, :, c], fit.mean
        # One more column moves the coefficients along (-cross, 1) by `times`: a parabola in it.
        slope = m @ others - (own @ m) @ cross - (v[:, c] - v[:, base] @ cross)
        bend = self._diagonals[part][:, c] - 2.0 * (others * cross).sum(axis=1) + (cross * (own @ cross)).sum(axis=1)
        return self._loss(self._errors(part, base, m)[:, None] + 2.0 * times * slope + times**2 * bend)

    def _loss(self, squares: np.ndarray) -> np.ndarray:
        """Sum over windows (windows, ...) of their losses."""
        logs = np.log1p(np.maximum(squares, 0.0) / self.freedom)
        return 0.5 * (self.freedom + self.data) * logs.sum(axis=0)


class _Fitted(NamedTuple):
    """Least squares on a base of columns.

    Attributes:
        rows: (k, n) of the normal matrix.
        vector, diagonal: (n,).
        inverse: (k, k).
        mean: (k,) coefficients.
    """

    rows: np.ndarray
    vector: np.ndarray
    diagonal: np.ndarray
    inverse: np.ndarray
    mean: np.ndarray

    def with_each(self, c: np.ndarray, least: np.ndarray, most: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Coefficients (columns,) of each of some columns beside the base, and what a unit of it takes (k, columns)."""
        rows = self.rows[:, c]
        cross = self.inverse @ rows
        curvature = self.diagonal[c] - (rows * cross).sum(axis=0)
        times = (self.vector[c] - self.mean @ rows) / np.maximum(curvature, _RIDGE * self.diagonal[c] + 1e-300)
        return np.clip(times, least, most), cross


def _gain(before: np.ndarray, after: np.ndarray, coefficient: float = np.nan) -> HeldOutGain:
    each = before - after
    error = np.sqrt(len(each)) * np.std(each, ddof=1) if len(each) > 1 else np.inf
    return HeldOutGain(float(each.sum()), float(error), float(coefficient), len(each))
