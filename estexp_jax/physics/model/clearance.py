"""Pairs of bodies that may touch by a robot's description but never come near in its recordings."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from estexp_jax.lanes.collision_pairs import contacts_on, touching_pairs
from estexp_jax.physics.model.collision_pairs import geom_distance, overlapping_bodies
from estexp_jax.physics.model.robot import Robot

NEAR, TOGETHER = 0.02, 0.005
"""Parts that come nearer, m, may touch in a simulation that moves a little otherwise; and in one that moves as these
do, as far as its rows tell. Meshes, whose contacts take MJX far longer than all else, are near only where they do so.
"""
_LOOSE, _SHARE, _PRESSED = 5e-4, 0.5, 1e-5
"""Parts that one joint or two hold together are always near: they may touch where their gap changes by more, m or as a
share of itself, or where they overlap by more, m."""
ROWS = 300
"""So many rows of each recording are looked at."""


def without_collisions(robot: Robot, paths: Sequence[np.ndarray], near: float = NEAR) -> list[tuple[int, int]]:
    """Pairs of bodies whose contacts can be left out, since they never came near.

    Two moving bodies, or one of a robot that is bolted down and one of its surroundings: what floats falls on these.
    Those whose meshes overlap from the start, too.

    Args:
        robot: as described.
        paths: (rows, nq) configurations of each recording.
        near: gap of parts that may touch, m.
    """
    model, data = robot.model, mujoco.MjData(robot.model)
    ever = overlapping_bodies(robot)
    pairs = {bodies: geoms for bodies, geoms in _pairs(robot).items() if bodies not in ever}
    met = set[tuple[int, int]]()
    mesh = model.geom_type == mujoco.mjtGeom.mjGEOM_MESH
    touch = {bodies: min(near, TOGETHER) if mesh[geoms].any() else near for bodies, geoms in pairs.items()}
    distances = {bodies: list[float]() for bodies in pairs if _are_joined(model, *bodies)}
    for path in paths if pairs else ():
        for qpos in path[:: max(1, len(path) // ROWS)]:
            data.qpos[:] = qpos
            mujoco.mj_kinematics(model, data)
            for bodies in pairs.keys() - met:
                found = min(geom_distance(model, data, one, other, 2.0 * NEAR) for one, other in pairs[bodies])
                if bodies in distances:
                    distances[bodies].append(found)
                elif found <= touch[bodies]:
                    met.add(bodies)
    met |= {bodies for bodies, found in distances.items() if _may_touch(found, touch[bodies])}
    return [*ever, *(bodies for bodies in pairs if bodies not in met)] if len(paths) else []


def pairs_that_touch(robot: Robot, paths: Sequence[np.ndarray]) -> bool:
    """Whether pairs that `without_collisions` leaves out at home come near in some motions.

    Args:
        robot: as described.
        paths: (rows, nq) configurations of each motion.
    """
    if not contacts_on(robot.model):
        return False
    left_out = without_collisions(robot, [robot.home()[None]], TOGETHER)
    return not set(left_out) <= set(without_collisions(robot, paths, TOGETHER))


def _may_touch(distances: list[float], near: float) -> bool:
    """Whether two parts that joints hold together may, by their gap along the recordings."""
    nearest = min(distances)
    return nearest < -_PRESSED or (nearest <= near and max(distances) - nearest > max(_LOOSE, _SHARE * nearest))


def _are_joined(model: mujoco.MjModel, one: int, other: int) -> bool:
    """Whether one of two rigid groups of bodies hangs from the other, or from what hangs from it."""

    def above(group: int) -> int:
        return int(model.body_weldid[model.body_parentid[group]])

    first, second = (int(model.body_weldid[body]) for body in (one, other))
    return second in (above(first), above(above(first))) or first in (above(second), above(above(second)))


def _pairs(robot: Robot) -> dict[tuple[int, int], list[tuple[int, int]]]:
    """Bodies that may touch by their description, and those of their geoms that may."""
    model, found = robot.model, dict[tuple[int, int], list[tuple[int, int]]]()
    for a, b in touching_pairs(model):
        first, second = sorted((int(model.geom_bodyid[a]), int(model.geom_bodyid[b])))
        bodies = first, second
        still = [model.body_weldid[body] == 0 for body in bodies]
        if not any(still) or not robot.floats(bodies[1 - still.index(True)]):
            found.setdefault(bodies, []).append((a, b))
    return found
