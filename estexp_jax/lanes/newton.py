"""The constrained accelerations: Newton's method on MuJoCo's convex problem, with a line search.

    minimise over a:  1/2 (a - a_smooth)^T M (a - a_smooth) + sum of the rows' costs at J a - a_ref

The cost is piecewise quadratic, so that few steps end at the minimum. All robots of a chunk iterate until the last has
converged.

Source: MuJoCo documentation, "Computation": "Newton solver"; Todorov 2014.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from estexp_jax.lanes.algebra import Scalar, mul, neg, sub
from estexp_jax.lanes.layout import Dof
from estexp_jax.lanes.rows import FrictionLoss, Residual, Rows
from estexp_jax.lanes.sparse import Entries, Factor, Pending, robot_sum, times

_EASY = 5
"""Newton steps in which, without friction losses, one look at the slope does for a line search."""
_WHOLE = 1e-4
"""A step this near to a full one counts as one."""
_TRIES = 12
"""Most points that a line search looks at."""
_FLAT = 0.01
"""Share of its first slope at which a line search ends; a full step within one quadratic piece has none."""


class Solution(NamedTuple):
    """Accelerations under constraints.

    Attributes:
        acceleration: per degree of freedom.
        force: constraint force there.
        residuals: of each rows, for reading contact forces off.
    """

    acceleration: list[Scalar]
    force: list[Scalar]
    residuals: list[Residual]


class _Guess(NamedTuple):
    x: tuple[Any, ...]
    momentum: tuple[Any, ...]  # M x
    residuals: tuple[Residual, ...]


def solve(
    dofs: Sequence[Dof],
    matrix: Entries,
    smooth: Sequence[Scalar],
    rows: Sequence[Rows],
    start: Sequence[Scalar],
    iterations: int,
    tolerance: float,
) -> Solution:
    """Solve.

    Args:
        dofs: structure.
        matrix: M.
        smooth: forces without constraints.
        rows: constraints; none: one linear solve.
        start: accelerations of the step before.
        iterations: at most.
        tolerance: squared change of the accelerations, relative to one plus their squares, that counts as none; a robot
            has also converged when a full step ends in the same quadratic piece that it began in.
    """
    if not rows:
        return Solution(Factor(dofs, matrix).solve(smooth), [0] * len(dofs), [])

    def residuals(x: Sequence[Scalar]) -> tuple[Residual, ...]:
        return tuple(tuple(j - a for j, a in zip(row.jacobian(dofs, x), row.reference(), strict=True)) for row in rows)

    sharp = any(isinstance(row, FrictionLoss) for row in rows)

    def step(count: Any, settled: Any, guess: _Guess) -> tuple[Any, _Guess]:
        pulled, curved = Pending(), Pending()
        for row, r in zip(rows, guess.residuals, strict=True):
            row.pull(r, pulled)
            row.curve(r, curved)
        gap = [sub(m, f) for m, f in zip(guess.momentum, smooth, strict=True)]
        slope = [sub(g, pulled.get(d.index, d.k)) for g, d in zip(gap, dofs, strict=True)]
        way = [neg(s) for s in Factor(dofs, matrix, curved).solve(slope)]
        far = times(dofs, matrix, way)
        along = tuple(row.jacobian(dofs, way) for row in rows)
        first = robot_sum([(d.k, mul(w, g)) for d, w, g in zip(dofs, way, gap, strict=True)])
        second = robot_sum([(d.k, mul(w, f)) for d, w, f in zip(dofs, way, far, strict=True)])

        downhill = robot_sum([(d.k, mul(w, g)) for d, w, g in zip(dofs, way, slope, strict=True)])

        def derivatives(length: Scalar) -> tuple[Scalar, Scalar]:
            """First and second derivative of the cost along the way."""
            ones, twos = [], []
            for row, r, s in zip(rows, guess.residuals, along, strict=True):
                one, two = row.line(tuple(x + length * y for x, y in zip(r, s, strict=True)), s)
                ones.append((row.k, one))
                twos.append((row.k, two))
            return first + length * second + robot_sum(ones), second + robot_sum(twos)

        one = jnp.ones_like(downhill)
        if sharp:
            length = _searched(derivatives, downhill, one, settled)
        else:
            slope, curvature = derivatives(one)
            nudged = one - slope / jnp.maximum(curvature, 1e-20)
            easy = count < _EASY
            length = _searched(derivatives, downhill, jnp.where(easy, nudged, one), settled | easy)
        whole = jnp.abs(length - 1.0) < _WHOLE
        length = jnp.where(settled, 0.0, length)  # so that a robot's motion does not depend on who is in its chunk
        ahead = lambda xs, ys: tuple(x + length * y for x, y in zip(xs, ys, strict=True))  # noqa: E731
        return whole, _Guess(
            ahead(guess.x, way),
            ahead(guess.momentum, far),
            tuple(ahead(r, s) for r, s in zip(guess.residuals, along, strict=True)),
        )

    def unfinished(carry: tuple[Any, Any, _Guess]) -> Any:
        count, settled, _ = carry
        return (count < iterations) & ~jnp.all(settled)

    def again(carry: tuple[Any, Any, _Guess]) -> tuple[Any, Any, _Guess]:
        count, settled, guess = carry
        whole, after = step(count, settled, guess)
        moved = robot_sum([(d.k, (a - b) ** 2) for d, a, b in zip(dofs, after.x, guess.x, strict=True)])
        size = robot_sum([(d.k, a**2) for d, a in zip(dofs, after.x, strict=True)])
        pairs = zip(rows, guess.residuals, after.residuals, strict=True)
        bends = robot_sum([(row.k, row.bends(r, s).astype(moved.dtype)) for row, r, s in pairs])
        on = ((bends > 0) | ~whole) & (moved > tolerance * (1.0 + size))  # false for a robot that blew up
        return count + 1, settled | ~on, after

    begin = _Guess(tuple(start), tuple(times(dofs, matrix, start)), residuals(start))
    nobody = jnp.zeros(start[0].shape[-1], bool)
    _, _, end = jax.lax.while_loop(unfinished, again, (0, nobody, begin))
    pulled = Pending()
    for row, r in zip(rows, end.residuals, strict=True):
        row.pull(r, pulled)
    force = [pulled.get(d.index, d.k) for d in dofs]
    return Solution(list(end.x), force, list(end.residuals))


def _searched(
    derivatives: Callable[[Scalar], tuple[Scalar, Scalar]], downhill: Scalar, begin: Scalar, found: Any
) -> Scalar:
    """Step length of least cost along a direction: Newton's method on the slope, which never falls, between bounds.

    Friction losses bend the cost so sharply that without bounds the method would jump to and fro over the bend.
    """

    def searching(carry: tuple[Any, ...]) -> Any:
        count, _, _, _, found = carry
        return (count < _TRIES) & ~jnp.all(found)

    def narrow(carry: tuple[Any, ...]) -> tuple[Any, ...]:
        count, length, low, high, found = carry
        slope, curvature = derivatives(length)
        found = found | ~(jnp.abs(slope) > _FLAT * jnp.abs(downhill))
        high, low = jnp.where(slope > 0, length, high), jnp.where(slope > 0, low, length)
        ahead = length - slope / jnp.maximum(curvature, 1e-20)
        halfway = jnp.where(jnp.isfinite(high), 0.5 * (low + high), 2.0 * length)
        ahead = jnp.where((ahead > low) & (ahead < high), ahead, halfway)
        return count + 1, jnp.where(found, length, ahead), low, high, found

    low, high = jnp.zeros_like(downhill), jnp.full_like(downhill, jnp.inf)
    return jax.lax.while_loop(searching, narrow, (0, begin, low, high, found))[1]
