"""Which geoms of a model may touch each other."""

from __future__ import annotations

import mujoco


def contacts_on(model: mujoco.MjModel) -> bool:
    """Whether a model's options leave contacts on at all."""
    return not model.opt.disableflags & (mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)


def touching_pairs(model: mujoco.MjModel) -> list[tuple[int, int]]:
    """Pairs of geoms that MuJoCo lets collide, a plane first.

    Source: MuJoCo documentation, "Collision detection", "Filtering".
    """
    excluded = {tuple(sorted(((s >> 16) & 0xFFFF, s & 0xFFFF))) for s in model.exclude_signature.tolist()}
    pairs = []
    for a in range(model.ngeom):
        for b in range(a + 1, model.ngeom):
            if _may_touch(model, a, b, excluded):
                plane_second = int(model.geom_type[b]) == mujoco.mjtGeom.mjGEOM_PLANE
                pairs.append((b, a) if plane_second else (a, b))
    return pairs


def _may_touch(model: mujoco.MjModel, a: int, b: int, excluded: set) -> bool:
    if not (model.geom_contype[a] & model.geom_conaffinity[b] or model.geom_contype[b] & model.geom_conaffinity[a]):
        return False
    one, two = int(model.geom_bodyid[a]), int(model.geom_bodyid[b])
    weld = model.body_weldid
    if weld[one] == weld[two] or tuple(sorted((one, two))) in excluded:
        return False
    filters = not model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_FILTERPARENT
    parents = [int(weld[model.body_parentid[weld[x]]]) for x in (one, two)]
    joined = weld[one] and weld[two] and (parents[0] == weld[two] or parents[1] == weld[one])
    return not (filters and joined)
