"""What sensors read of a state, as MuJoCo defines them; each reading is one array (N,).

Source: MuJoCo documentation, "XML reference": "sensor"; `engine_sensor.c`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import jax.numpy as jnp
import mujoco

from estexp_jax.physics.engines.lanes.algebra import (
    Matrix,
    Scalar,
    Vector,
    add,
    apply,
    cross,
    dot,
    neg,
    scale,
    total,
    transposed,
    vadd,
    vsub,
)
from estexp_jax.physics.engines.lanes.contacts import Contact
from estexp_jax.physics.engines.lanes.dynamics import Inertias
from estexp_jax.physics.engines.lanes.numbers import Numbers
from estexp_jax.physics.engines.lanes.plan import Plan
from estexp_jax.physics.engines.lanes.rays import meets
from estexp_jax.physics.engines.lanes.rows import Residual
from estexp_jax.physics.engines.lanes.step import Instant

_SENSOR, _OBJECT = mujoco.mjtSensor, mujoco.mjtObj


class Reader:
    """Reads sensors off an instant."""

    def __init__(self, plan: Plan, numbers: Numbers, inertias: Inertias) -> None:
        """For robots of these numbers."""
        self._plan, self._numbers, self._inertias = plan, numbers, inertias

    def read(self, now: Instant, sensors: Sequence[int]) -> dict[int, Scalar]:
        """Readings (N,) by their address in `sensordata`, of the sensors with these indices."""
        model, found = self._plan.model, {}
        for sensor in sensors:
            kind = _SENSOR(int(model.sensor_type[sensor]))
            values = _READINGS[kind](self, now, sensor)
            cutoff, first = float(model.sensor_cutoff[sensor]), int(model.sensor_adr[sensor])
            for n, value in enumerate(values):
                found[first + n] = value if cutoff <= 0.0 else jnp.clip(value, -cutoff, cutoff)
        return found

    def _object(self, sensor: int) -> int:
        return int(self._plan.model.sensor_objid[sensor])

    def joint_position(self, now: Instant, sensor: int) -> tuple[Scalar, ...]:
        """`jointpos`."""
        slot, member = self._joint(self._object(sensor))
        return (_one(now.state.qpos[slot][0], member),)

    def joint_speed(self, now: Instant, sensor: int) -> tuple[Scalar, ...]:
        """`jointvel`."""
        slot, member = self._joint(self._object(sensor))
        return (_one(now.state.qvel[self._plan.joints[slot].dofs[0]], member),)

    def _joint(self, joint: int) -> tuple[int, int]:
        return next((n, j.ids.index(joint)) for n, j in enumerate(self._plan.joints) if joint in j.ids)

    def actuator_force(self, now: Instant, sensor: int) -> tuple[Scalar, ...]:
        """`actuatorfrc`."""
        actuator = self._object(sensor)
        return next((_one(x, ids.index(actuator)),) for ids, x in now.pulled.actuator.items() if actuator in ids)

    def joint_actuator_force(self, now: Instant, sensor: int) -> tuple[Scalar, ...]:
        """`jointactuatorfrc`."""
        slot, member = self._joint(self._object(sensor))
        torque = now.pulled.motor[self._plan.joints[slot].dofs[0]]
        return (_one(torque, member) + jnp.zeros_like(_one(now.state.qvel[0], 0)),)

    def touch(self, now: Instant, sensor: int) -> tuple[Scalar, ...]:
        """`touch`: normal forces of the body's contacts whose line of force meets the site."""
        site, body = self._object(sensor), int(self._plan.model.site_bodyid[self._object(sensor)])
        forces = [
            self._felt(now, contact, residual, member, site)
            for contact, residual in now.touched
            for member, geom in enumerate(contact.candidate.geoms)
            if int(self._plan.model.geom_bodyid[geom]) == body
        ]
        return (total(forces) + jnp.zeros_like(_one(now.state.qvel[0], 0)),)

    def _felt(self, now: Instant, contact: Contact, residual: Residual, member: int, site: int) -> Scalar:
        force = _one(contact.normal_force(residual), member)
        rotation, place = self._site(now, site)
        point = tuple(_one(x, member) for x in contact.position)
        ray = tuple(neg(_one(x, member)) for x in contact.normal)
        local = transposed(rotation)
        start, way = apply(local, vsub(point, place)), apply(local, ray)
        shape, size = mujoco.mjtGeom(int(self._plan.model.site_type[site])), self._plan.model.site_size[site]
        return jnp.where((force > 0) & meets(shape, size, start, way), force, 0.0)

    def frame_position(self, now: Instant, sensor: int) -> Vector:
        """`framepos`, world axes."""
        _, place, origin, _ = self._frame(now, sensor)
        return self._full(now, vadd(place, origin))

    def frame_velocity(self, now: Instant, sensor: int) -> Vector:
        """`framelinvel`, world axes."""
        _, place, _, body = self._frame(now, sensor)
        return self._full(now, self._velocity(now, body, place))

    def frame_spin(self, now: Instant, sensor: int) -> Vector:
        """`frameangvel`, world axes."""
        group, member = self._plan.place_of_body[self._frame(now, sensor)[3]]
        return self._full(now, _each(now.moving.poses[group].spin, member))

    def velocimeter(self, now: Instant, sensor: int) -> Vector:
        """`velocimeter`, in the site's axes."""
        rotation, place, _, body = self._frame(now, sensor)
        return self._full(now, apply(transposed(rotation), self._velocity(now, body, place)))

    def gyro(self, now: Instant, sensor: int) -> Vector:
        """`gyro`, in the site's axes."""
        rotation, _, _, body = self._frame(now, sensor)
        group, member = self._plan.place_of_body[body]
        return self._full(now, apply(transposed(rotation), _each(now.moving.poses[group].spin, member)))

    def accelerometer(self, now: Instant, sensor: int) -> Vector:
        """`accelerometer`, in the site's axes: gravity shows as an upward acceleration."""
        rotation, place, _, body = self._frame(now, sensor)
        group, member = self._plan.place_of_body[body]
        pose = now.moving.poses[group]
        spin, rate = _each(pose.spin, member), _each(pose.spin_rate, member)
        arm = vsub(place, _each(pose.position, member))
        whole = vadd(_each(pose.acceleration, member), vadd(cross(rate, arm), cross(spin, cross(spin, arm))))
        for i in self._plan.groups[group].chain:
            k = self._plan.dofs[i].k
            above = member * k // self._plan.groups[group].k if k > 1 else 0
            unit = vadd(_each(now.moving.linear[i], above), cross(_each(now.moving.angular[i], above), place))
            whole = vadd(whole, scale(_one(now.solution.acceleration[i], above), unit))
        return self._full(now, apply(transposed(rotation), whole))

    def subtree_centre(self, now: Instant, sensor: int) -> Vector:
        """`subtreecom`, world axes."""
        model, top = self._plan.model, self._object(sensor)
        mass: Scalar = 0
        moment: Vector = (0, 0, 0)
        for body in range(1, model.nbody):
            above = body
            while above > top:
                above = int(model.body_parentid[above])
            if above == top and body in self._plan.place_of_body:
                group, member = self._plan.place_of_body[body]
                weight = _one(self._inertias.mass[group], member)
                pose = now.moving.poses[group]
                arm = apply(_turn(pose.rotation, member), _each(self._inertias.centre[group], member))
                centre = vadd(vadd(_each(pose.position, member), arm), _each(now.moving.origin[group], member))
                mass, moment = add(mass, weight), vadd(moment, scale(weight, centre))
        return self._full(now, scale(1.0 / mass, moment))

    def _velocity(self, now: Instant, body: int, place: Vector) -> Vector:
        group, member = self._plan.place_of_body[body]
        pose = now.moving.poses[group]
        arm = vsub(place, _each(pose.position, member))
        return vadd(_each(pose.velocity, member), cross(_each(pose.spin, member), arm))

    def _frame(self, now: Instant, sensor: int) -> tuple[Matrix, Vector, Vector, int]:
        """Axes, place about the tree's origin, the origin, and the body of what a sensor sits on."""
        model, target = self._plan.model, self._object(sensor)
        kind = _OBJECT(int(model.sensor_objtype[sensor]))
        prefix = {_OBJECT.mjOBJ_SITE: "site", _OBJECT.mjOBJ_GEOM: "geom"}.get(kind)
        if prefix:
            body = int(getattr(model, f"{prefix}_bodyid")[target])
            offset, turned = self._numbers.vector(f"{prefix}_pos", [target]), f"{prefix}_quat"
        else:
            body, turned = target, "body_iquat"
            inertial = kind == _OBJECT.mjOBJ_BODY
            offset = self._numbers.vector("body_ipos", [target]) if inertial else (0, 0, 0)
        group, member = self._plan.place_of_body[body]
        pose = now.moving.poses[group]
        rotation = _turn(pose.rotation, member)
        place = vadd(_each(pose.position, member), apply(rotation, offset))
        local = self._numbers.rotation(turned, [target])
        axes = tuple(tuple(dot(row, column) for column in transposed(local)) for row in rotation)
        return axes, place, _each(now.moving.origin[group], member), body

    def _site(self, now: Instant, site: int) -> tuple[Matrix, Vector]:
        group, member = self._plan.place_of_body[int(self._plan.model.site_bodyid[site])]
        pose = now.moving.poses[group]
        rotation = _turn(pose.rotation, member)
        place = vadd(_each(pose.position, member), apply(rotation, self._numbers.vector("site_pos", [site])))
        local = self._numbers.rotation("site_quat", [site])
        return tuple(tuple(dot(row, column) for column in transposed(local)) for row in rotation), place

    def _full(self, now: Instant, v: Vector) -> Vector:
        """As arrays (N,), also where a component is known."""
        zero = jnp.zeros_like(_one(now.state.qvel[0], 0))
        return tuple(zero + x for x in v)


def _one(x: Scalar, member: int) -> Scalar:
    """One member of a group's scalar."""
    if isinstance(x, (int, float)) or x.ndim < 2:
        return x
    return x[member if x.shape[0] > 1 else 0]


def _each(v: Vector, member: int) -> Vector:
    return tuple(_one(x, member) for x in v)


def _turn(rotation: Matrix, member: int) -> Matrix:
    return tuple(_each(row, member) for row in rotation)


_READINGS: dict[mujoco.mjtSensor, Callable[[Reader, Instant, int], Sequence[Scalar]]] = {
    _SENSOR.mjSENS_JOINTPOS: Reader.joint_position,
    _SENSOR.mjSENS_JOINTVEL: Reader.joint_speed,
    _SENSOR.mjSENS_ACTUATORFRC: Reader.actuator_force,
    _SENSOR.mjSENS_JOINTACTFRC: Reader.joint_actuator_force,
    _SENSOR.mjSENS_TOUCH: Reader.touch,
    _SENSOR.mjSENS_FRAMEPOS: Reader.frame_position,
    _SENSOR.mjSENS_FRAMELINVEL: Reader.frame_velocity,
    _SENSOR.mjSENS_FRAMEANGVEL: Reader.frame_spin,
    _SENSOR.mjSENS_VELOCIMETER: Reader.velocimeter,
    _SENSOR.mjSENS_GYRO: Reader.gyro,
    _SENSOR.mjSENS_ACCELEROMETER: Reader.accelerometer,
    _SENSOR.mjSENS_SUBTREECOM: Reader.subtree_centre,
}

SENSORS = frozenset(_READINGS)
"""Sensor types that lanes read."""
