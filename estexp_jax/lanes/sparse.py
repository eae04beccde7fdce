"""Linear algebra on matrices with the sparsity of the tree: an entry for each degree of freedom and those above it.

M = L^T D L in the order of the tree leaves no fill-in. Source: Featherstone 2008, section 6.5 (LTDL factorisation).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

from estexp_jax.lanes.algebra import Scalar, add, mul, sub, sum_over_children, to_children, total
from estexp_jax.lanes.layout import Dof

Entries = dict[tuple[int, int], Scalar]
"""(i, j) for each degree of freedom i and j above it, or i itself: the lower half of a symmetric matrix."""


@final
class Pending:
    """Sums that come from groups of several sizes, added up per size and gathered once."""

    def __init__(self) -> None:
        """Nothing yet."""
        self._parts: dict[object, dict[int, Scalar]] = {}

    def add(self, key: object, k: int, x: Scalar) -> None:
        """Add a scalar of k members to an entry."""
        part = self._parts.setdefault(key, {})
        part[k] = add(part.get(k, 0), x)

    def get(self, key: object, k: int) -> Scalar:
        """The entry for k members."""
        return total(sum_over_children(x, size, k) for size, x in self._parts.get(key, {}).items())


@final
class Factor:
    """L and the inverse of D."""

    def __init__(self, dofs: Sequence[Dof], matrix: Entries, plus: Pending | None = None) -> None:
        """Factorise `matrix`, with `plus` added to it."""
        self._dofs = dofs
        self.lower: Entries = {}
        self.inverse: dict[int, Scalar] = {}
        taken = Pending()

        def entry(i: int, j: int) -> Scalar:
            k = dofs[i].k
            whole = add(matrix[i, j], plus.get((i, j), k)) if plus else matrix[i, j]
            return sub(whole, taken.get((i, j), k))

        for dof in reversed(dofs):
            i = dof.index
            self.inverse[i] = 1.0 / entry(i, i)
            row = {j: entry(i, j) for j in dof.above}
            for n, j in enumerate(dof.above):
                self.lower[i, j] = mul(row[j], self.inverse[i])
                for a in dof.above[: n + 1]:
                    taken.add((j, a), dof.k, mul(self.lower[i, j], row[a]))

    def solve(self, right: Sequence[Scalar]) -> list[Scalar]:
        """The solution of M x = right."""
        taken, y = Pending(), list(right)
        for dof in reversed(self._dofs):
            y[dof.index] = sub(right[dof.index], taken.get(dof.index, dof.k))
            for j in dof.above:
                taken.add(j, dof.k, mul(self.lower[dof.index, j], y[dof.index]))
        for dof in self._dofs:
            i = dof.index
            above = total(mul(self.lower[i, j], to_children(y[j], self._dofs[j].k, dof.k)) for j in dof.above)
            y[i] = sub(mul(y[i], self.inverse[i]), above)
        return y


def times(dofs: Sequence[Dof], matrix: Entries, x: Sequence[Scalar]) -> list[Scalar]:
    """M x."""
    below = Pending()
    for dof in dofs:
        for j in dof.above:
            below.add(j, dof.k, mul(matrix[dof.index, j], x[dof.index]))
    return [
        total(
            [mul(matrix[d.index, d.index], x[d.index])]
            + [mul(matrix[d.index, j], to_children(x[j], dofs[j].k, d.k)) for j in d.above]
            + [below.get(d.index, d.k)]
        )
        for d in dofs
    ]


def robot_sum(parts: Sequence[tuple[int, Scalar]]) -> Scalar:
    """Sum over all members of scalars (k, x): one number a robot."""
    pending = Pending()
    for k, x in parts:
        pending.add(None, k, x)
    return pending.get(None, 1)
