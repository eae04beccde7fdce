"""What sensors read of a state, as MuJoCo defines them; each reading is one array (N,).

Source: MuJoCo documentation, "XML reference": "sensor"; `engine_sensor.c`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property

import jax.numpy as jnp
import mujoco
import numpy as np

from estexp_jax.lanes.algebra import (
    Scalar,
    Vector,
    apply,
    cross,
    each,
    neg,
    one,
    scale,
    total,
    transposed,
    vadd,
    vsub,
)
from estexp_jax.lanes.attitude import attitude, product, quaternion
from estexp_jax.lanes.contacts import Contact
from estexp_jax.lanes.dynamics import Inertias
from estexp_jax.lanes.layout import Plan
from estexp_jax.lanes.model_parameters import Numbers
from estexp_jax.lanes.rays import meets
from estexp_jax.lanes.rows import Residual
from estexp_jax.lanes.sensor_frames import Seats, on_fixed_body, seat_of
from estexp_jax.lanes.step import Instant

_SENSOR = mujoco.mjtSensor
_AXES = (_SENSOR.mjSENS_FRAMEXAXIS, _SENSOR.mjSENS_FRAMEYAXIS, _SENSOR.mjSENS_FRAMEZAXIS)


class Reader:
    """Reads sensors off an instant."""

    def __init__(self, plan: Plan, numbers: Numbers, inertias: Inertias) -> None:
        """For robots of these numbers."""
        self._plan, self._numbers, self._seats = plan, numbers, Seats(plan, numbers, inertias)

    def read(self, now: Instant, sensors: Sequence[int]) -> dict[int, Scalar]:
        """Readings (N,) by their address in `sensordata`, of the sensors with these indices."""
        model, found = self._plan.model, {}
        for sensor in sensors:
            kind, first = _SENSOR(int(model.sensor_type[sensor])), int(model.sensor_adr[sensor])
            if kind in RESTING and on_fixed_body(model, sensor):
                values = self._full(now, self._at_rest[first : first + int(model.sensor_dim[sensor])].tolist())
            else:
                values = _READINGS[kind](self, now, sensor)
            cutoff = float(model.sensor_cutoff[sensor])
            for n, value in enumerate(values):
                found[first + n] = value if cutoff <= 0.0 else jnp.clip(value, -cutoff, cutoff)
        return found

    @cached_property
    def _at_rest(self) -> np.ndarray:
        """`sensordata` of the robot as described: what sensors on bodies that cannot move always show."""
        model = self._plan.model
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        return data.sensordata.copy()

    def _object(self, sensor: int) -> int:
        return int(self._plan.model.sensor_objid[sensor])

    def joint_position(self, now: Instant, sensor: int) -> tuple[Scalar, ...]:
        """`jointpos`."""
        slot, member = self._joint(self._object(sensor))
        return (one(now.state.qpos[slot][0], member),)

    def joint_speed(self, now: Instant, sensor: int) -> tuple[Scalar, ...]:
        """`jointvel`."""
        slot, member = self._joint(self._object(sensor))
        return (one(now.state.qvel[self._plan.joints[slot].dofs[0]], member),)

    def _joint(self, joint: int) -> tuple[int, int]:
        return next((n, j.ids.index(joint)) for n, j in enumerate(self._plan.joints) if joint in j.ids)

    def actuator_force(self, now: Instant, sensor: int) -> tuple[Scalar, ...]:
        """`actuatorfrc`."""
        actuator = self._object(sensor)
        return next((one(x, ids.index(actuator)),) for ids, x in now.pulled.actuator.items() if actuator in ids)

    def joint_actuator_force(self, now: Instant, sensor: int) -> tuple[Scalar, ...]:
        """`jointactuatorfrc`."""
        slot, member = self._joint(self._object(sensor))
        torque = now.pulled.motor[self._plan.joints[slot].dofs[0]]
        return (one(torque, member) + jnp.zeros_like(one(now.state.qvel[0], 0)),)

    def touch(self, now: Instant, sensor: int) -> tuple[Scalar, ...]:
        """`touch`: normal forces of the body's contacts whose line of force meets the site."""
        site, body = self._object(sensor), int(self._plan.model.site_bodyid[self._object(sensor)])
        forces = [
            self._felt(now, contact, residual, member, site)
            for contact, residual in now.touched
            for member, geom in enumerate(contact.candidate.geoms)
            if int(self._plan.model.geom_bodyid[geom]) == body
        ]
        return (total(forces) + jnp.zeros_like(one(now.state.qvel[0], 0)),)

    def _felt(self, now: Instant, contact: Contact, residual: Residual, member: int, site: int) -> Scalar:
        force = one(contact.normal_force(residual), member)
        rotation, place = self._seats.site(now, site)
        point = tuple(one(x, member) for x in contact.position)
        ray = tuple(neg(one(x, member)) for x in contact.normal)
        local = transposed(rotation)
        start, way = apply(local, vsub(point, place)), apply(local, ray)
        shape, size = mujoco.mjtGeom(int(self._plan.model.site_type[site])), self._plan.model.site_size[site]
        return jnp.where((force > 0) & meets(shape, size, start, way), force, 0.0)

    def frame_position(self, now: Instant, sensor: int) -> Vector:
        """`framepos`, world axes."""
        _, place, origin, _ = self._seats.frame(now, sensor)
        return self._full(now, vadd(place, origin))

    def frame_velocity(self, now: Instant, sensor: int) -> Vector:
        """`framelinvel`, world axes."""
        _, place, _, body = self._seats.frame(now, sensor)
        return self._full(now, self._seats.velocity(now, body, place))

    def frame_spin(self, now: Instant, sensor: int) -> Vector:
        """`frameangvel`, world axes."""
        group, member = self._plan.place_of_body[self._seats.frame(now, sensor)[3]]
        return self._full(now, each(now.moving.poses[group].spin, member))

    def frame_axis(self, now: Instant, sensor: int) -> Vector:
        """`framexaxis`, `frameyaxis`, `framezaxis`, world axes."""
        axes, *_ = self._seats.frame(now, sensor)
        column = _AXES.index(_SENSOR(int(self._plan.model.sensor_type[sensor])))
        return self._full(now, tuple(row[column] for row in axes))

    def frame_quaternion(self, now: Instant, sensor: int) -> Sequence[Scalar]:
        """`framequat`."""
        body, seat = seat_of(self._plan.model, sensor)
        found = attitude(self._plan, self._numbers, now.state.qpos, body)
        if seat:
            found = product(found, quaternion(self._numbers, f"{seat}quat", self._object(sensor)))
        return self._full(now, found)

    def velocimeter(self, now: Instant, sensor: int) -> Vector:
        """`velocimeter`, in the site's axes."""
        rotation, place, _, body = self._seats.frame(now, sensor)
        return self._full(now, apply(transposed(rotation), self._seats.velocity(now, body, place)))

    def gyro(self, now: Instant, sensor: int) -> Vector:
        """`gyro`, in the site's axes."""
        rotation, _, _, body = self._seats.frame(now, sensor)
        group, member = self._plan.place_of_body[body]
        return self._full(now, apply(transposed(rotation), each(now.moving.poses[group].spin, member)))

    def accelerometer(self, now: Instant, sensor: int) -> Vector:
        """`accelerometer`, in the site's axes: gravity shows as an upward acceleration."""
        rotation, place, _, body = self._seats.frame(now, sensor)
        group, member = self._plan.place_of_body[body]
        pose = now.moving.poses[group]
        spin, rate = each(pose.spin, member), each(pose.spin_rate, member)
        arm = vsub(place, each(pose.position, member))
        whole = vadd(each(pose.acceleration, member), vadd(cross(rate, arm), cross(spin, cross(spin, arm))))
        for i in self._plan.groups[group].chain:
            k = self._plan.dofs[i].k
            above = member * k // self._plan.groups[group].k if k > 1 else 0
            unit = vadd(each(now.moving.linear[i], above), cross(each(now.moving.angular[i], above), place))
            whole = vadd(whole, scale(one(now.solution.acceleration[i], above), unit))
        return self._full(now, apply(transposed(rotation), whole))

    def subtree_centre(self, now: Instant, sensor: int) -> Vector:
        """`subtreecom`, world axes."""
        seats = self._seats
        mass, moment = seats.weighed(
            self._object(sensor), lambda body: vadd(seats.centre(now, body), seats.origin(now, body))
        )
        return self._full(now, scale(1.0 / mass, moment))

    def subtree_velocity(self, now: Instant, sensor: int) -> Vector:
        """`subtreelinvel`, world axes."""
        seats = self._seats
        mass, momentum = seats.weighed(
            self._object(sensor), lambda body: seats.velocity(now, body, seats.centre(now, body))
        )
        return self._full(now, scale(1.0 / mass, momentum))

    def _full(self, now: Instant, v: Sequence[Scalar]) -> Vector:
        """As arrays (N,), also where a component is known."""
        zero = jnp.zeros_like(one(now.state.qvel[0], 0))
        return tuple(zero + x for x in v)


_READINGS: dict[mujoco.mjtSensor, Callable[[Reader, Instant, int], Sequence[Scalar]]] = {
    _SENSOR.mjSENS_JOINTPOS: Reader.joint_position,
    _SENSOR.mjSENS_JOINTVEL: Reader.joint_speed,
    _SENSOR.mjSENS_ACTUATORFRC: Reader.actuator_force,
    _SENSOR.mjSENS_JOINTACTFRC: Reader.joint_actuator_force,
    _SENSOR.mjSENS_TOUCH: Reader.touch,
    _SENSOR.mjSENS_FRAMEPOS: Reader.frame_position,
    _SENSOR.mjSENS_FRAMEQUAT: Reader.frame_quaternion,
    **dict.fromkeys(_AXES, Reader.frame_axis),
    _SENSOR.mjSENS_FRAMELINVEL: Reader.frame_velocity,
    _SENSOR.mjSENS_FRAMEANGVEL: Reader.frame_spin,
    _SENSOR.mjSENS_VELOCIMETER: Reader.velocimeter,
    _SENSOR.mjSENS_GYRO: Reader.gyro,
    _SENSOR.mjSENS_ACCELEROMETER: Reader.accelerometer,
    _SENSOR.mjSENS_SUBTREECOM: Reader.subtree_centre,
    _SENSOR.mjSENS_SUBTREELINVEL: Reader.subtree_velocity,
}

SENSORS = frozenset(_READINGS)
"""Sensor types that lanes read."""
RESTING = frozenset(
    {
        *(_SENSOR.mjSENS_FRAMEPOS, _SENSOR.mjSENS_FRAMEQUAT, *_AXES),
        *(_SENSOR.mjSENS_FRAMELINVEL, _SENSOR.mjSENS_FRAMEANGVEL, _SENSOR.mjSENS_VELOCIMETER, _SENSOR.mjSENS_GYRO),
    }
)
"""Those that always show the same where their body cannot move."""
