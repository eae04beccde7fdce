"""Sparse linear regression by evidence: which groups of columns are needed, greedily added, exchanged and dropped.

Data r = J z + noise of deviation one. Columns of nuisances have a normal prior about 0 of known precision and always
count; they are integrated out. Columns of groups that may be chosen are free, and each of a group's numbers costs half
the logarithm of the number of observations: the evidence under a unit-information prior, to leading order. Every group
chosen has prior odds, which make up for how many there are to choose from.

Sources: Schwarz, Annals of Statistics 6 (1978); Kass and Wasserman, Journal of the American Statistical Association 90
(1995), unit-information prior; Scott and Berger, Annals of Statistics 38 (2010), multiplicity.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, final

import numpy as np

_RIDGE = 1e-9
"""Precision of a free column, as a share of what the data say of it."""


class Posterior(NamedTuple):
    """A choice of groups with its coefficients.

    Attributes:
        groups: those chosen.
        columns: (k,) of the chosen groups and the nuisances, ascending.
        mean: (k,) their coefficients.
        covariance: (k, k).
        log_evidence: with the price of the choice, in nats.
    """

    groups: frozenset[int]
    columns: np.ndarray
    mean: np.ndarray
    covariance: np.ndarray
    log_evidence: float

    def coefficients(self, n: int) -> np.ndarray:
        """Coefficients (n,) of all columns, 0 where not chosen."""
        found = np.zeros(n)
        found[self.columns] = self.mean
        return found


@final
@dataclass(frozen=True, eq=False)
class SparseRegression:
    """Normal equations of all columns, and what may be chosen.

    Attributes:
        matrix: (n, n) J' J of whitened columns.
        vector: (n,) J' r.
        observations: how many independent data there are.
        precision: (n,) of nuisances' prior; 0 for columns of groups.
        groups: columns of each group.
        slots: (groups,) of groups with the same slot at most one is chosen.
        low, high: (n,) bounds of the coefficients.
        n_parameters: (groups,) how many parameters of an effect each fixes.
        log_odds: (groups,) prior odds of each, nats.
    """

    matrix: np.ndarray
    vector: np.ndarray
    observations: float
    precision: np.ndarray
    groups: Sequence[np.ndarray]
    slots: Sequence[int]
    low: np.ndarray
    high: np.ndarray
    n_parameters: np.ndarray
    log_odds: np.ndarray

    @cached_property
    def prior(self) -> np.ndarray:
        """Precision (n,) of all columns' priors."""
        return np.where(self.precision > 0.0, self.precision, _RIDGE * np.diag(self.matrix) + 1e-300)

    @cached_property
    def prices(self) -> np.ndarray:
        """What each group costs (groups,), nats."""
        return 0.5 * np.log(max(self.observations, 2.0)) * np.asarray(self.n_parameters, float) - self.log_odds

    @cached_property
    def _nuisances(self) -> np.ndarray:
        return np.flatnonzero(self.precision > 0.0)

    @cached_property
    def _single(self) -> np.ndarray:
        """Column (groups,) of groups of one; -1 of others."""
        return np.array([g[0] if len(g) == 1 else -1 for g in self.groups], dtype=int)

    def posterior(self, groups: Iterable[int]) -> Posterior:
        """The posterior under a choice of groups; the evidence is -inf where a coefficient leaves its bounds."""
        chosen = frozenset(groups)
        own = [self.groups[g] for g in chosen]
        columns = np.sort(np.concatenate([self._nuisances, *own]).astype(int))
        if not len(columns):
            return Posterior(chosen, columns, np.zeros(0), np.zeros((0, 0)), 0.0)
        prior = self.prior[columns]
        m = self.matrix[np.ix_(columns, columns)] + np.diag(prior)
        scale = np.sqrt(np.diag(m))
        covariance = np.linalg.inv(m / np.outer(scale, scale)) / np.outer(scale, scale)
        mean = covariance @ self.vector[columns]
        log_evidence = 0.5 * self.vector[columns] @ mean - self.prices[list(chosen)].sum()
        inside = (mean >= self.low[columns]) & (mean <= self.high[columns])
        free = np.isin(columns, self._nuisances)
        return Posterior(chosen, columns, mean, covariance, log_evidence if (inside | free).all() else -np.inf)

    def gains(self, at: Posterior) -> np.ndarray:
        """What adding each group of one column would raise the log evidence by, (groups,); -inf where it cannot be."""
        s, single = at.columns, np.maximum(self._single, 0)
        cross = self.matrix[np.ix_(single, s)] if len(s) else np.zeros((len(single), 0))
        left = self.vector[single] - cross @ at.mean
        prior = self.prior[single]
        curvature = np.diag(self.matrix)[single] + prior - np.einsum("gs,st,gt->g", cross, at.covariance, cross)
        curvature = np.maximum(curvature, 10.0 * _RIDGE * np.diag(self.matrix)[single] + 1e-300)
        mean = left / curvature
        gain = 0.5 * left * mean - self.prices
        inside = (mean >= self.low[single]) & (mean <= self.high[single]) & (np.diag(self.matrix)[single] > 0.0)
        taken = {self.slots[g] for g in at.groups}
        open_ = np.array([slot not in taken for slot in self.slots], dtype=bool)
        return np.where(inside & open_ & (self._single >= 0), gain, -np.inf)

    def search(
        self, start: Collection[int] = (), allowed: Collection[int] | None = None, *, exchange: bool = True
    ) -> Posterior:
        """The choice at which no addition, removal or exchange of one group raises the evidence.

        Args:
            start: groups to begin with.
            allowed: groups that may be added; None: all.
            exchange: whether groups are exchanged, too.
        """
        shut = np.ones(len(self.groups), dtype=bool)
        shut[list(range(len(self.groups)) if allowed is None else allowed)] = False
        at = self.pruned(start)
        while True:
            better = self._added(at, shut)
            if better is None and exchange:
                better = self._exchanged(at, shut)
            if better is None:
                return at
            at = self._pruned(better)

    def pruned(self, groups: Collection[int]) -> Posterior:
        """The choice of some of these groups at which no removal raises the evidence, all within their bounds."""
        return self._pruned(self.posterior(groups), force=True)

    def _added(self, at: Posterior, shut: np.ndarray) -> Posterior | None:
        gains = np.where(shut, -np.inf, self.gains(at))
        for g in np.argsort(-gains)[:8].tolist():
            if not gains[g] > 0.0:
                return None
            found = self.posterior(at.groups | {g})
            if found.log_evidence > at.log_evidence:
                return found
        return None

    def _exchanged(self, at: Posterior, shut: np.ndarray) -> Posterior | None:
        best = None
        for g in sorted(at.groups):
            rest = self.posterior(at.groups - {g})
            gains = np.where(shut, -np.inf, self.gains(rest))
            gains[g] = -np.inf
            other = int(np.argmax(gains))
            if not np.isfinite(gains[other]) or rest.log_evidence + gains[other] <= at.log_evidence + 1e-6:
                continue
            found = self.posterior(rest.groups | {other})
            if found.log_evidence > max(at.log_evidence + 1e-6, best.log_evidence if best else -np.inf):
                best = found
        return best

    def _pruned(self, at: Posterior, *, force: bool = False) -> Posterior:
        """Without the groups whose removal raises the evidence; at first also without what leaves its bounds."""
        while at.groups:
            found = max((self.posterior(at.groups - {g}) for g in sorted(at.groups)), key=lambda p: p.log_evidence)
            if found.log_evidence <= at.log_evidence and not (force and not np.isfinite(at.log_evidence)):
                break
            if not np.isfinite(found.log_evidence):
                found = self.posterior(at.groups - {self._worst(at)})
            at = found
        return at

    def _worst(self, at: Posterior) -> int:
        """The group that leaves its bounds farthest, in standard deviations."""
        mean = at.coefficients(len(self.vector))
        std = np.ones(len(self.vector))
        std[at.columns] = np.sqrt(np.maximum(np.diag(at.covariance), 1e-300))
        out = np.maximum(self.low - mean, mean - self.high) / std
        return max(at.groups, key=lambda g: float(out[self.groups[g]].max()))

    def odds_of(self, at: Posterior) -> dict[int, float]:
        """Log odds that each chosen group is there, against the same choice without it, nats."""
        return {g: at.log_evidence - self.posterior(at.groups - {g}).log_evidence for g in sorted(at.groups)}
