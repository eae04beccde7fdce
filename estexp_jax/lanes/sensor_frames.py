"""Poses and velocities of the frames that sensors are attached to: sites, geoms and bodies."""

from __future__ import annotations

from collections.abc import Callable
from typing import final

import mujoco

from estexp_jax.lanes.algebra import (
    Matrix,
    Scalar,
    Vector,
    add,
    apply,
    cross,
    dot,
    member_of,
    members_of,
    scale,
    transposed,
    vadd,
    vsub,
)
from estexp_jax.lanes.dynamics import Inertias
from estexp_jax.lanes.layout import Layout
from estexp_jax.lanes.model_parameters import ModelParameters
from estexp_jax.lanes.step import StepState

_OBJECT = mujoco.mjtObj
FRAMES = (_OBJECT.mjOBJ_SITE, _OBJECT.mjOBJ_GEOM, _OBJECT.mjOBJ_BODY, _OBJECT.mjOBJ_XBODY)
"""Objects that motion sensors may be attached to."""


@final
class SensorFrames:
    """Places, axes and speeds at an instant; each component is an array (N,)."""

    def __init__(self, layout: Layout, params: ModelParameters, inertias: Inertias) -> None:
        """For robots of these numbers."""
        self._layout, self._params, self._inertias = layout, params, inertias

    def frame(self, now: StepState, sensor: int) -> tuple[Matrix, Vector, Vector, int]:
        """Axes, place about the tree's origin, the origin, and the body of what a sensor sits on."""
        body, prefix = sensor_frame_of(self._layout.model, sensor)
        group, member = self._layout.place_of_body[body]
        pose, origin = now.moving.poses[group], members_of(now.moving.origin[group], member)
        rotation, place = _turn(pose.rotation, member), members_of(pose.position, member)
        if not prefix:
            return rotation, place, origin, body
        axes, place = self._on(rotation, place, prefix, int(self._layout.model.sensor_objid[sensor]))
        return axes, place, origin, body

    def site(self, now: StepState, site: int) -> tuple[Matrix, Vector]:
        """Axes of a site, and its place about the tree's origin."""
        group, member = self._layout.place_of_body[int(self._layout.model.site_bodyid[site])]
        pose = now.moving.poses[group]
        return self._on(_turn(pose.rotation, member), members_of(pose.position, member), "site_", site)

    def _on(self, rotation: Matrix, place: Vector, prefix: str, element: int) -> tuple[Matrix, Vector]:
        """Axes and place of an element fixed to a body whose axes and place these are."""
        local = self._params.rotation(f"{prefix}quat", [element])
        axes = tuple(tuple(dot(row, column) for column in transposed(local)) for row in rotation)
        return axes, vadd(place, apply(rotation, self._params.vector(f"{prefix}pos", [element])))

    def velocity(self, now: StepState, body: int, place: Vector) -> Vector:
        """Velocity of a body's point at a place about the tree's origin, world axes."""
        group, member = self._layout.place_of_body[body]
        pose = now.moving.poses[group]
        arm = vsub(place, members_of(pose.position, member))
        return vadd(members_of(pose.velocity, member), cross(members_of(pose.spin, member), arm))

    def centre(self, now: StepState, body: int) -> Vector:
        """Centre of mass of a body about its tree's origin."""
        group, member = self._layout.place_of_body[body]
        pose = now.moving.poses[group]
        arm = apply(_turn(pose.rotation, member), members_of(self._inertias.centre[group], member))
        return vadd(members_of(pose.position, member), arm)

    def origin(self, now: StepState, body: int) -> Vector:
        """Origin of a body's tree."""
        group, member = self._layout.place_of_body[body]
        return members_of(now.moving.origin[group], member)

    def weighed(self, top: int, of: Callable[[int], Vector]) -> tuple[Scalar, Vector]:
        """Mass of the subtree under a body, and the sum of what each body of it has times its mass."""
        model = self._layout.model
        mass: Scalar = 0
        whole: Vector = (0, 0, 0)
        for body in range(1, model.nbody):
            above = body
            while above > top:
                above = int(model.body_parentid[above])
            if above == top and body in self._layout.place_of_body:
                group, member = self._layout.place_of_body[body]
                weight = member_of(self._inertias.mass[group], member)
                mass, whole = add(mass, weight), vadd(whole, scale(weight, of(body)))
        return mass, whole


def _turn(rotation: Matrix, member: int) -> Matrix:
    return tuple(members_of(row, member) for row in rotation)


def sensor_frame_of(model: mujoco.MjModel, sensor: int) -> tuple[int, str]:
    """The body of what a sensor is on, and how the pose fields of that begin, if it is not the body itself."""
    kind, target = _OBJECT(int(model.sensor_objtype[sensor])), int(model.sensor_objid[sensor])
    match kind:
        case _OBJECT.mjOBJ_SITE:
            return int(model.site_bodyid[target]), "site_"
        case _OBJECT.mjOBJ_GEOM:
            return int(model.geom_bodyid[target]), "geom_"
        case _OBJECT.mjOBJ_BODY:
            return target, "body_i"
        case _:
            return target, ""


def on_fixed_body(model: mujoco.MjModel, sensor: int) -> bool:
    """Whether a sensor is on a site, geom or body that cannot move."""
    if _OBJECT(int(model.sensor_objtype[sensor])) not in FRAMES:
        return False
    return int(model.body_weldid[sensor_frame_of(model, sensor)[0]]) == 0
