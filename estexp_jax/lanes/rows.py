"""Constraints as MuJoCo writes them: soft rows J a = a_ref, each with a stiffness D and a range of forces.

Three kinds, each a convex function of the residual r = J a - a_ref: contacts (pushing only, with a friction pyramid),
stops (pushing only), friction losses (bounded). Each adds its pull on the joints and its curvature.

Source: MuJoCo documentation, "Computation": "Constraint model", "Parameters", "Friction cones".
"""

from __future__ import annotations

import abc
from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import jax.numpy as jnp

from estexp_jax.lanes.algebra import (
    Scalar,
    Vector,
    add,
    clip,
    dot,
    mul,
    to_children,
    total,
)
from estexp_jax.lanes.layout import Dof
from estexp_jax.lanes.sparse import Pending

Residual = tuple[Scalar, ...]
"""One array (k, N) for each row of k alike constraints."""


class Rows(abc.ABC):
    """Alike constraints of k members."""

    k: int

    @abc.abstractmethod
    def jacobian(self, dofs: Sequence[Dof], x: Sequence[Scalar]) -> Residual:
        """J x."""

    @abc.abstractmethod
    def reference(self) -> Residual:
        """a_ref."""

    @abc.abstractmethod
    def bends(self, r: Residual, s: Residual) -> Scalar:
        """(k, N) whether the cost is another quadratic function at s than at r."""

    @abc.abstractmethod
    def line(self, r: Residual, d: Residual) -> tuple[Scalar, Scalar]:
        """First and second derivative of the cost at r along d, (k, N)."""

    @abc.abstractmethod
    def pull(self, r: Residual, on: Pending) -> None:
        """Add J^T times the forces to each degree of freedom."""

    @abc.abstractmethod
    def curve(self, r: Residual, on: Pending) -> None:
        """Add J^T (second derivative of the cost) J to each pair of degrees of freedom."""


@final
@dataclass(frozen=True, eq=False)
class Pyramid(Rows):
    """Contacts with friction: four edges each.

    Attributes:
        k: contacts.
        chain: degrees of freedom that move them.
        axes: for each of the chain, the velocity of the point along two tangents and the normal at unit speed.
        mu: friction coefficient, regularised.
        stiffness: D of each edge; 0 where nothing touches.
        aref: of the four edges.
    """

    k: int
    chain: tuple[int, ...]
    axes: tuple[Vector, ...]
    mu: Scalar
    stiffness: Scalar
    aref: Residual

    def jacobian(self, dofs: Sequence[Dof], x: Sequence[Scalar]) -> Residual:
        moved = [to_children(x[i], dofs[i].k, self.k) for i in self.chain]
        one, two, normal = (total(mul(a[e], v) for a, v in zip(self.axes, moved, strict=True)) for e in range(3))
        one, two = mul(self.mu, one), mul(self.mu, two)
        return (normal + one, normal - one, normal + two, normal - two)

    def reference(self) -> Residual:
        return self.aref

    def bends(self, r: Residual, s: Residual) -> Scalar:
        crossed = [(x < 0) != (y < 0) for x, y in zip(r, s, strict=True)]
        return (crossed[0] | crossed[1] | crossed[2] | crossed[3]) & (self.stiffness > 0)

    def line(self, r: Residual, d: Residual) -> tuple[Scalar, Scalar]:
        active = [jnp.where(x < 0, self.stiffness * s, 0.0) for x, s in zip(r, d, strict=True)]
        return dot(active, r), dot(active, d)

    def forces(self, r: Residual) -> tuple[Scalar, Scalar, Scalar]:
        """Along the tangents and the normal."""
        f = [-self.stiffness * jnp.minimum(x, 0.0) for x in r]
        return self.mu * (f[0] - f[1]), self.mu * (f[2] - f[3]), f[0] + f[1] + f[2] + f[3]

    def pull(self, r: Residual, on: Pending) -> None:
        force = self.forces(r)
        for axis, i in zip(self.axes, self.chain, strict=True):
            on.add(i, self.k, dot(axis, force))

    def curve(self, r: Residual, on: Pending) -> None:
        a: list[Scalar] = [jnp.where(x < 0, self.stiffness, 0.0) for x in r]
        first, second, mu = a[0] + a[1], a[2] + a[3], self.mu
        oo, tt, nn = mu * mu * first, mu * mu * second, first + second
        on_, tn = mu * (a[0] - a[1]), mu * (a[2] - a[3])
        for n, (x, i) in enumerate(zip(self.axes, self.chain, strict=True)):
            weighed = (
                add(mul(oo, x[0]), mul(on_, x[2])),
                add(mul(tt, x[1]), mul(tn, x[2])),
                total((mul(on_, x[0]), mul(tn, x[1]), mul(nn, x[2]))),
            )
            for y, j in zip(self.axes[: n + 1], self.chain[: n + 1], strict=True):
                on.add((i, j), self.k, dot(y, weighed))


@final
@dataclass(frozen=True, eq=False)
class ContactPush(Rows):
    """Constraints of one row that only push: stops, contacts without friction.

    Attributes:
        k: members.
        chain: degrees of freedom they act on.
        along: for each of them, J.
        stiffness: D; 0 where not active.
        aref: of the row.
    """

    k: int
    chain: tuple[int, ...]
    along: tuple[Scalar, ...]
    stiffness: Scalar
    aref: Scalar

    def jacobian(self, dofs: Sequence[Dof], x: Sequence[Scalar]) -> Residual:
        moved = [to_children(x[i], dofs[i].k, self.k) for i in self.chain]
        return (dot(self.along, moved),)

    def reference(self) -> Residual:
        return (self.aref,)

    def bends(self, r: Residual, s: Residual) -> Scalar:
        return ((r[0] < 0) != (s[0] < 0)) & (self.stiffness > 0)

    def line(self, r: Residual, d: Residual) -> tuple[Scalar, Scalar]:
        active = jnp.where(r[0] < 0, self.stiffness * d[0], 0.0)
        return active * r[0], active * d[0]

    def forces(self, r: Residual) -> Scalar:
        """Along the row."""
        return -self.stiffness * jnp.minimum(r[0], 0.0)

    def pull(self, r: Residual, on: Pending) -> None:
        force = self.forces(r)
        for along, i in zip(self.along, self.chain, strict=True):
            on.add(i, self.k, mul(along, force))

    def curve(self, r: Residual, on: Pending) -> None:
        active = jnp.where(r[0] < 0, self.stiffness, 0.0)
        for n, (x, i) in enumerate(zip(self.along, self.chain, strict=True)):
            weighed = mul(active, x)
            for y, j in zip(self.along[: n + 1], self.chain[: n + 1], strict=True):
                on.add((i, j), self.k, mul(y, weighed))


@final
@dataclass(frozen=True, eq=False)
class FrictionLoss(Rows):
    """Friction losses: forces up to a bound.

    Attributes:
        k: members.
        dof: where they act.
        stiffness: D.
        bound: N m or N.
        aref: of the row.
    """

    k: int
    dof: int
    stiffness: Scalar
    bound: Scalar
    aref: Scalar

    def jacobian(self, dofs: Sequence[Dof], x: Sequence[Scalar]) -> Residual:
        return (x[self.dof],)

    def reference(self) -> Residual:
        return (self.aref,)

    def bends(self, r: Residual, s: Residual) -> Scalar:
        edge = self.bound / self.stiffness
        return ((jnp.abs(r[0]) < edge) != (jnp.abs(s[0]) < edge)) | ((r[0] < 0) != (s[0] < 0)) & (edge > 0)

    def line(self, r: Residual, d: Residual) -> tuple[Scalar, Scalar]:
        force = self.stiffness * r[0]
        held = jnp.abs(force) < self.bound
        return clip(force, -self.bound, self.bound) * d[0], jnp.where(held, self.stiffness * d[0] * d[0], 0.0)

    def pull(self, r: Residual, on: Pending) -> None:
        on.add(self.dof, self.k, -clip(self.stiffness * r[0], -self.bound, self.bound))

    def curve(self, r: Residual, on: Pending) -> None:
        held = jnp.abs(self.stiffness * r[0]) < self.bound
        on.add((self.dof, self.dof), self.k, jnp.where(held, self.stiffness, 0.0))
