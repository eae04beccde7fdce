"""Arithmetic on lanes that leaves out what is known to be zero or one.

A *scalar* is a Python number, known when the step is traced, or an array: (N,) for one element in N robots, (k, N) for
k alike elements, (k, 1) for k numbers that all robots share. The geometry of robots is full of zeros and ones, and XLA
does not remove them from floating-point code.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import jax.numpy as jnp

Scalar = Any
"""A Python number, or an array with the robots as last axis."""
Vector = Sequence[Scalar]
"""Three scalars."""
Matrix = Sequence[Vector]
"""Three rows."""

ZERO: tuple[Scalar, ...] = (0, 0, 0)


def is_number(a: Scalar, value: float) -> bool:
    """Whether a scalar is known to be this number."""
    return isinstance(a, (int, float)) and a == value


def mul(a: Scalar, b: Scalar) -> Scalar:
    """Product."""
    if is_number(a, 0) or is_number(b, 0):
        return 0
    if is_number(a, 1):
        return b
    if is_number(b, 1):
        return a
    if is_number(a, -1):
        return neg(b)
    if is_number(b, -1):
        return neg(a)
    return a * b


def neg(a: Scalar) -> Scalar:
    """-a."""
    return 0 if is_number(a, 0) else -a


def add(a: Scalar, b: Scalar) -> Scalar:
    """Sum of two."""
    if is_number(a, 0):
        return b
    return a if is_number(b, 0) else a + b


def sub(a: Scalar, b: Scalar) -> Scalar:
    """Difference."""
    if is_number(b, 0):
        return a
    return neg(b) if is_number(a, 0) else a - b


def total(terms: Iterable[Scalar]) -> Scalar:
    """Sum of scalars."""
    result: Scalar = 0
    for term in terms:
        result = add(result, term)
    return result


def minimum(a: Scalar, b: Scalar) -> Scalar:
    """The lesser, known where both are."""
    if isinstance(a, (int, float)) and isinstance(b, (int, float)):
        return min(a, b)
    return jnp.minimum(a, b)


def maximum(a: Scalar, b: Scalar) -> Scalar:
    """The greater, known where both are."""
    if isinstance(a, (int, float)) and isinstance(b, (int, float)):
        return max(a, b)
    return jnp.maximum(a, b)


def clip(a: Scalar, low: Scalar, high: Scalar) -> Scalar:
    """`a` between two limits."""
    return minimum(maximum(a, low), high)


def dot(a: Sequence[Scalar], b: Sequence[Scalar]) -> Scalar:
    """Scalar product."""
    return total(mul(x, y) for x, y in zip(a, b, strict=True))


def vadd(a: Vector, b: Vector) -> Vector:
    """Sum of two vectors."""
    return tuple(add(x, y) for x, y in zip(a, b, strict=True))


def vsub(a: Vector, b: Vector) -> Vector:
    """Difference of two vectors."""
    return tuple(sub(x, y) for x, y in zip(a, b, strict=True))


def scale(s: Scalar, a: Vector) -> Vector:
    """Multiple of a vector."""
    return tuple(mul(s, x) for x in a)


def cross(a: Vector, b: Vector) -> Vector:
    """Vector product."""
    return (
        sub(mul(a[1], b[2]), mul(a[2], b[1])),
        sub(mul(a[2], b[0]), mul(a[0], b[2])),
        sub(mul(a[0], b[1]), mul(a[1], b[0])),
    )


def apply(rotation: Matrix, v: Vector) -> Vector:
    """R v."""
    return tuple(dot(row, v) for row in rotation)


def transposed(m: Matrix) -> Matrix:
    """The transpose."""
    return tuple(zip(*m, strict=True))


def compose(a: Matrix, b: Matrix) -> Matrix:
    """A B."""
    columns = transposed(b)
    return tuple(tuple(dot(row, column) for column in columns) for row in a)


def rotation_about(axis: Vector, sine: Scalar, cosine: Scalar) -> Matrix:
    """Rotation about a unit axis by the angle of this sine and cosine (Rodrigues)."""
    rest = sub(1, cosine)
    x, y, z = axis
    p = [[mul(mul(u, v), rest) for v in axis] for u in axis]
    return (
        (add(cosine, p[0][0]), sub(p[0][1], mul(z, sine)), add(p[0][2], mul(y, sine))),
        (add(p[1][0], mul(z, sine)), add(cosine, p[1][1]), sub(p[1][2], mul(x, sine))),
        (sub(p[2][0], mul(y, sine)), add(p[2][1], mul(x, sine)), add(cosine, p[2][2])),
    )


def from_quaternion(w: Scalar, x: Scalar, y: Scalar, z: Scalar) -> Matrix:
    """Rotation matrix of a unit quaternion."""
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )


# A symmetric matrix is six scalars: xx, yy, zz, xy, xz, yz.
Symmetric = Sequence[Scalar]


def symmetric_apply(m: Symmetric, v: Vector) -> Vector:
    """M v."""
    xx, yy, zz, xy, xz, yz = m
    return (dot((xx, xy, xz), v), dot((xy, yy, yz), v), dot((xz, yz, zz), v))


def symmetric_rotated(rotation: Matrix, m: Symmetric) -> Symmetric:
    """R M R^T."""
    xx, yy, zz, xy, xz, yz = m
    half = compose(rotation, ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)))
    return tuple(dot(half[i], rotation[j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))


def parallel_axis(inertia: Symmetric, mass: Scalar, centre: Vector) -> Symmetric:
    """Inertia about the origin of one given about its centre of mass (parallel axes)."""
    first = scale(mass, centre)
    xx, yy, zz = (mul(f, c) for f, c in zip(first, centre, strict=True))
    return (
        add(inertia[0], add(yy, zz)),
        add(inertia[1], add(xx, zz)),
        add(inertia[2], add(xx, yy)),
        sub(inertia[3], mul(first[0], centre[1])),
        sub(inertia[4], mul(first[0], centre[2])),
        sub(inertia[5], mul(first[1], centre[2])),
    )


def to_children(x: Scalar, k_from: int, k_to: int) -> Scalar:
    """A parent's scalar (k_from, N) for each of its children (k_to, N), children of one parent side by side."""
    if k_from in (1, k_to) or not _per_element(x):
        return x
    return jnp.repeat(x, k_to // k_from, axis=0)


def sum_over_children(x: Scalar, k_from: int, k_to: int) -> Scalar:
    """The sum over the children of each parent: (k_from, N) to (k_to, N), or (N,) for one parent."""
    if k_from == k_to or is_number(x, 0):
        return x
    if not _per_element(x) or x.shape[0] == 1:
        return x * (k_from // k_to)
    if k_to == 1:
        return _tree_sum([x[i] for i in range(k_from)])
    return x.reshape(k_to, k_from // k_to, *x.shape[1:]).sum(1)


def _tree_sum(rows: list[Scalar]) -> Scalar:
    while len(rows) > 1:
        pairs = [a + b for a, b in zip(rows[::2], rows[1::2], strict=False)]
        rows = pairs + rows[2 * len(pairs) :]
    return rows[0]


def _per_element(x: Scalar) -> bool:
    return not isinstance(x, (int, float)) and x.ndim == 2


def all_to_children(xs: Sequence[Scalar], k_from: int, k_to: int) -> tuple[Scalar, ...]:
    """`to_children` of each."""
    return tuple(to_children(x, k_from, k_to) for x in xs)


def member_of(x: Scalar, member: int) -> Scalar:
    """One member of a group's scalar."""
    if isinstance(x, (int, float)) or x.ndim < 2:
        return x
    return x[member if x.shape[0] > 1 else 0]


def members_of(v: Sequence[Scalar], member: int) -> tuple[Scalar, ...]:
    """One member of several scalars of a group."""
    return tuple(member_of(x, member) for x in v)
