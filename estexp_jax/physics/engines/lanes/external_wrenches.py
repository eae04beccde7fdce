"""Forces that effects put on bodies from outside, in lanes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import jax.numpy as jnp

from estexp_jax.lanes.algebra import Vector, apply, vadd
from estexp_jax.lanes.kinematics import body_motion
from estexp_jax.lanes.layout import Layout
from estexp_jax.lanes.model_parameters import ModelParameters
from estexp_jax.lanes.step import LaneState
from estexp_jax.physics.effects.base import BodyForce
from estexp_jax.physics.effects.changes import Values
from estexp_jax.physics.model.robot import Robot


def external_wrenches(
    robot: Robot,
    effects: Sequence[BodyForce],
    layout: Layout,
    params: ModelParameters,
    values: Values,
    state: LaneState,
) -> dict[int, Vector]:
    """Force on the centre of mass of each group's bodies, N, world axes, by the group's index.

    Args:
        robot: the nominal robot.
        effects: what pulls.
        layout: structure.
        params: of the robots.
        values: (n_sites, n_parameters, N) of each effect.
        state: of the robots.
    """
    found: dict[int, Vector] = {}
    moving = body_motion(layout, params, state.qpos, state.qvel)
    for effect in effects:
        sites = [robot.index("body", site) for site in effect.sites(robot)]
        for group in layout.groups:
            if not set(group.bodies) & set(sites):
                continue
            pose = moving.poses[group.index]
            arm = apply(pose.rotation, params.vector("body_ipos", group.bodies))
            centre = vadd(vadd(pose.position, arm), moving.origin[group.index])
            mine = tuple(_members(group.bodies, sites, x) for x in jnp.moveaxis(values[effect.name], 1, 0))
            force, before = effect.force_on_body(mine, tuple(centre)), found.get(group.index)
            found[group.index] = force if before is None else vadd(before, force)
    return found


def _members(bodies: Sequence[int], sites: list[int], values: Any) -> Any:
    rows = [values[sites.index(b)] if b in sites else jnp.zeros_like(values[0]) for b in bodies]
    return rows[0] if len(rows) == 1 else jnp.stack(rows)
