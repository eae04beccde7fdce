"""Contact candidates of a robot with a plane: the points of its spheres, capsules and boxes.

Source: MuJoCo `engine_collision_primitive.c`; a sphere touches at one point, a capsule at the ends of its axis (which
also turns the contact's frame), a box at its lower corners.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, final

import mujoco
import numpy as np

from estexp_jax.lanes.collision_pairs import contacts_on, touching_pairs

_GEOM = mujoco.mjtGeom
SHAPES = (_GEOM.mjGEOM_SPHERE, _GEOM.mjGEOM_CAPSULE, _GEOM.mjGEOM_BOX)


@final
@dataclass(frozen=True)
class Candidate:
    """Alike points that may touch a plane.

    Attributes:
        shape: of their geoms.
        plane: index of the plane's geom.
        geoms: (k,) MuJoCo's indices of their geoms.
        at: for each, the point in the frame of its geom, in units of `geom_size`: a capsule's end (0, 0, +-1) is one
            half length along z, a box's corner (+-1, +-1, +-1).
        condim: 1 (no friction) or 3.
    """

    shape: mujoco.mjtGeom
    plane: int
    geoms: tuple[int, ...]
    at: tuple[tuple[int, int, int], ...]
    condim: int

    @property
    def signature(self) -> Any:
        """Properties that points in one array share."""
        return int(self.shape), self.plane, self.condim

    @property
    def k(self) -> int:
        """Number of points."""
        return len(self.geoms)

    @classmethod
    def joined(cls, alike: Sequence[Candidate]) -> Candidate:
        """Points of one signature, side by side."""
        first = alike[0]
        geoms = tuple(g for c in alike for g in c.geoms)
        return cls(first.shape, first.plane, geoms, tuple(p for c in alike for p in c.at), first.condim)


def candidates(model: mujoco.MjModel) -> dict[int, tuple[Candidate, ...]]:
    """The single points of each moving body, in MuJoCo's order of planes and geoms."""
    found: dict[int, list[Candidate]] = {}
    if not contacts_on(model):
        return {}
    for plane, geom in touching_pairs(model):
        if int(model.geom_type[plane]) != _GEOM.mjGEOM_PLANE:
            continue
        shape = _GEOM(int(model.geom_type[geom]))
        condim = _condim(model, plane, geom)
        for at in _points(shape):
            body = int(model.geom_bodyid[geom])
            found.setdefault(body, []).append(Candidate(shape, plane, (geom,), (at,), condim))
    return {body: tuple(points) for body, points in found.items()}


def _condim(model: mujoco.MjModel, plane: int, geom: int) -> int:
    priority = model.geom_priority
    if priority[plane] == priority[geom]:
        return int(max(model.geom_condim[plane], model.geom_condim[geom]))
    return int(model.geom_condim[plane if priority[plane] > priority[geom] else geom])


def _points(shape: mujoco.mjtGeom) -> list[tuple[int, int, int]]:
    if shape == _GEOM.mjGEOM_CAPSULE:
        return [(0, 0, 1), (0, 0, -1)]
    if shape == _GEOM.mjGEOM_BOX:
        return [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    return [(0, 0, 0)]


def mixed(model: mujoco.MjModel, plane: int, geom: int) -> tuple[np.ndarray, np.ndarray]:
    """The solref (2,) and solimp (5,) of a contact, mixed as MuJoCo does; these are the same for all robots.

    Source: MuJoCo documentation, "Contact parameters".
    """
    priority, mix = model.geom_priority, model.geom_solmix
    if priority[plane] != priority[geom]:
        chosen = plane if priority[plane] > priority[geom] else geom
        return model.geom_solref[chosen], model.geom_solimp[chosen]
    small = mujoco.mjMINVAL
    first, second = mix[plane], mix[geom]
    if first >= small and second >= small:
        share = first / (first + second)
    elif first < small and second < small:
        share = 0.5
    else:
        share = 0.0 if first < small else 1.0
    refs = model.geom_solref[[plane, geom]]
    ref = share * refs[0] + (1 - share) * refs[1] if refs[0, 0] > 0 and refs[1, 0] > 0 else refs.min(axis=0)
    return ref, share * model.geom_solimp[plane] + (1 - share) * model.geom_solimp[geom]
