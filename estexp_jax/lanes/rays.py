"""Whether a contact's line of force meets the site of a touch sensor.

Source: MuJoCo `engine_ray.c`.
"""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp
import mujoco
import numpy as np

from estexp_jax.lanes.algebra import Scalar, Vector, add, dot, is_number, mul, sub

_GEOM = mujoco.mjtGeom
TOUCH_SHAPES = (_GEOM.mjGEOM_SPHERE, _GEOM.mjGEOM_BOX, _GEOM.mjGEOM_CAPSULE)
"""Shapes of touch sensors' sites."""


def ray_intersection(shape: mujoco.mjtGeom, size: np.ndarray, start: Vector, way: Vector) -> Any:
    """Whether a ray from `start` along the unit vector `way`, in a shape's axes, meets the shape."""
    if shape == _GEOM.mjGEOM_SPHERE:
        return _meets_ball(float(size[0]), start, way)
    if shape == _GEOM.mjGEOM_BOX:
        return _meets_box(size, start, way)
    half = float(size[1])
    ends = [_meets_ball(float(size[0]), (start[0], start[1], sub(start[2], s * half)), way) for s in (-1, 1)]
    a = add(mul(way[0], way[0]), mul(way[1], way[1]))
    b = add(mul(way[0], start[0]), mul(way[1], start[1]))
    c = start[0] * start[0] + start[1] * start[1] - float(size[0]) ** 2
    root = jnp.sqrt(jnp.maximum(b * b - a * c, 0.0))
    far: Scalar = jnp.where(a > 1e-12, (-b + root) / jnp.maximum(a, 1e-12), 0.0)
    near: Scalar = jnp.where(a > 1e-12, (-b - root) / jnp.maximum(a, 1e-12), 0.0)
    heights = [jnp.abs(start[2] + t * way[2]) <= half for t in (near, far)]
    side = (b * b - a * c >= 0) & (((near >= 0) & heights[0]) | ((far >= 0) & heights[1]))
    return side | ends[0] | ends[1]


def _meets_ball(radius: float, start: Vector, way: Vector) -> Any:
    b, c = dot(start, way), dot(start, start) - radius * radius
    root = b * b - c
    return (root >= 0) & (-b + jnp.sqrt(jnp.maximum(root, 0.0)) >= 0)


def _meets_box(size: np.ndarray, start: Vector, way: Vector) -> Any:
    first, last = -jnp.inf, jnp.inf
    for x, w, half in zip(start, way, size.tolist(), strict=True):
        if is_number(w, 0):
            w = 1e-12
        w = jnp.where(jnp.abs(w) < 1e-12, 1e-12, w)
        one, two = (-half - x) / w, (half - x) / w
        first, last = jnp.maximum(first, jnp.minimum(one, two)), jnp.minimum(last, jnp.maximum(one, two))
    return (last >= first) & (last >= 0)
