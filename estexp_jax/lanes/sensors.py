"""Sensor readings of a state, as MuJoCo defines them; each reading is one array (N,).

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
    member_of,
    members_of,
    neg,
    scale,
    total,
    transposed,
    vadd,
    vsub,
)
from estexp_jax.lanes.attitude import attitude, quaternion, quaternion_product
from estexp_jax.lanes.contacts import Contact
from estexp_jax.lanes.dynamics import Inertias
from estexp_jax.lanes.layout import Layout
from estexp_jax.lanes.model_parameters import ModelParameters
from estexp_jax.lanes.rays import ray_intersection
from estexp_jax.lanes.rows import Residual
from estexp_jax.lanes.sensor_frames import SensorFrames, on_fixed_body, sensor_frame_of
from estexp_jax.lanes.step import StepState

_SENSOR = mujoco.mjtSensor
_AXES = (_SENSOR.mjSENS_FRAMEXAXIS, _SENSOR.mjSENS_FRAMEYAXIS, _SENSOR.mjSENS_FRAMEZAXIS)


class SensorReader:
    """Reads sensors off an instant."""

    def __init__(self, layout: Layout, params: ModelParameters, inertias: Inertias) -> None:
        """For robots of these numbers."""
        self._layout, self._params, self._frames = layout, params, SensorFrames(layout, params, inertias)

    def read(self, now: StepState, sensors: Sequence[int]) -> dict[int, Scalar]:
        """Readings (N,) by their address in `sensordata`, of the sensors with these indices."""
        model, found = self._layout.model, {}
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
        model = self._layout.model
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        return data.sensordata.copy()

    def _object(self, sensor: int) -> int:
        return int(self._layout.model.sensor_objid[sensor])

    def joint_position(self, now: StepState, sensor: int) -> tuple[Scalar, ...]:
        """`jointpos`."""
        slot, member = self._joint(self._object(sensor))
        return (member_of(now.state.qpos[slot][0], member),)

    def joint_speed(self, now: StepState, sensor: int) -> tuple[Scalar, ...]:
        """`jointvel`."""
        slot, member = self._joint(self._object(sensor))
        return (member_of(now.state.qvel[self._layout.joints[slot].dofs[0]], member),)

    def _joint(self, joint: int) -> tuple[int, int]:
        return next((n, j.ids.index(joint)) for n, j in enumerate(self._layout.joints) if joint in j.ids)

    def actuator_force(self, now: StepState, sensor: int) -> tuple[Scalar, ...]:
        """`actuatorfrc`."""
        actuator = self._object(sensor)
        return next((member_of(x, ids.index(actuator)),) for ids, x in now.pulled.actuator.items() if actuator in ids)

    def joint_actuator_force(self, now: StepState, sensor: int) -> tuple[Scalar, ...]:
        """`jointactuatorfrc`."""
        slot, member = self._joint(self._object(sensor))
        torque = now.pulled.motor[self._layout.joints[slot].dofs[0]]
        return (member_of(torque, member) + jnp.zeros_like(member_of(now.state.qvel[0], 0)),)

    def touch(self, now: StepState, sensor: int) -> tuple[Scalar, ...]:
        """`touch`: normal forces of the body's contacts whose line of force meets the site."""
        site, body = self._object(sensor), int(self._layout.model.site_bodyid[self._object(sensor)])
        forces = [
            self._felt(now, contact, residual, member, site)
            for contact, residual in now.touched
            for member, geom in enumerate(contact.candidate.geoms)
            if int(self._layout.model.geom_bodyid[geom]) == body
        ]
        return (total(forces) + jnp.zeros_like(member_of(now.state.qvel[0], 0)),)

    def _felt(self, now: StepState, contact: Contact, residual: Residual, member: int, site: int) -> Scalar:
        force = member_of(contact.normal_force(residual), member)
        rotation, place = self._frames.site(now, site)
        point = tuple(member_of(x, member) for x in contact.position)
        ray = tuple(neg(member_of(x, member)) for x in contact.normal)
        local = transposed(rotation)
        start, way = apply(local, vsub(point, place)), apply(local, ray)
        shape, size = mujoco.mjtGeom(int(self._layout.model.site_type[site])), self._layout.model.site_size[site]
        return jnp.where((force > 0) & ray_intersection(shape, size, start, way), force, 0.0)

    def frame_position(self, now: StepState, sensor: int) -> Vector:
        """`framepos`, world axes."""
        _, place, origin, _ = self._frames.frame(now, sensor)
        return self._full(now, vadd(place, origin))

    def frame_velocity(self, now: StepState, sensor: int) -> Vector:
        """`framelinvel`, world axes."""
        _, place, _, body = self._frames.frame(now, sensor)
        return self._full(now, self._frames.velocity(now, body, place))

    def frame_spin(self, now: StepState, sensor: int) -> Vector:
        """`frameangvel`, world axes."""
        group, member = self._layout.place_of_body[self._frames.frame(now, sensor)[3]]
        return self._full(now, members_of(now.moving.poses[group].spin, member))

    def frame_axis(self, now: StepState, sensor: int) -> Vector:
        """`framexaxis`, `frameyaxis`, `framezaxis`, world axes."""
        axes, *_ = self._frames.frame(now, sensor)
        column = _AXES.index(_SENSOR(int(self._layout.model.sensor_type[sensor])))
        return self._full(now, tuple(row[column] for row in axes))

    def frame_quaternion(self, now: StepState, sensor: int) -> Sequence[Scalar]:
        """`framequat`."""
        body, prefix = sensor_frame_of(self._layout.model, sensor)
        found = attitude(self._layout, self._params, now.state.qpos, body)
        if prefix:
            found = quaternion_product(found, quaternion(self._params, f"{prefix}quat", self._object(sensor)))
        return self._full(now, found)

    def velocimeter(self, now: StepState, sensor: int) -> Vector:
        """`velocimeter`, in the site's axes."""
        rotation, place, _, body = self._frames.frame(now, sensor)
        return self._full(now, apply(transposed(rotation), self._frames.velocity(now, body, place)))

    def gyro(self, now: StepState, sensor: int) -> Vector:
        """`gyro`, in the site's axes."""
        rotation, _, _, body = self._frames.frame(now, sensor)
        group, member = self._layout.place_of_body[body]
        return self._full(now, apply(transposed(rotation), members_of(now.moving.poses[group].spin, member)))

    def accelerometer(self, now: StepState, sensor: int) -> Vector:
        """`accelerometer`, in the site's axes: gravity shows as an upward acceleration."""
        rotation, place, _, body = self._frames.frame(now, sensor)
        group, member = self._layout.place_of_body[body]
        pose = now.moving.poses[group]
        spin, rate = members_of(pose.spin, member), members_of(pose.spin_rate, member)
        arm = vsub(place, members_of(pose.position, member))
        whole = vadd(members_of(pose.acceleration, member), vadd(cross(rate, arm), cross(spin, cross(spin, arm))))
        for i in self._layout.groups[group].chain:
            k = self._layout.dofs[i].k
            above = member * k // self._layout.groups[group].k if k > 1 else 0
            unit = vadd(members_of(now.moving.linear[i], above), cross(members_of(now.moving.angular[i], above), place))
            whole = vadd(whole, scale(member_of(now.solution.acceleration[i], above), unit))
        return self._full(now, apply(transposed(rotation), whole))

    def subtree_centre(self, now: StepState, sensor: int) -> Vector:
        """`subtreecom`, world axes."""
        frames = self._frames
        mass, first_moment = frames.weighed(
            self._object(sensor), lambda body: vadd(frames.centre(now, body), frames.origin(now, body))
        )
        return self._full(now, scale(1.0 / mass, first_moment))

    def subtree_velocity(self, now: StepState, sensor: int) -> Vector:
        """`subtreelinvel`, world axes."""
        frames = self._frames
        mass, momentum = frames.weighed(
            self._object(sensor), lambda body: frames.velocity(now, body, frames.centre(now, body))
        )
        return self._full(now, scale(1.0 / mass, momentum))

    def _full(self, now: StepState, v: Sequence[Scalar]) -> Vector:
        """As arrays (N,), also where a component is known."""
        zero = jnp.zeros_like(member_of(now.state.qvel[0], 0))
        return tuple(zero + x for x in v)


_READINGS: dict[mujoco.mjtSensor, Callable[[SensorReader, StepState, int], Sequence[Scalar]]] = {
    _SENSOR.mjSENS_JOINTPOS: SensorReader.joint_position,
    _SENSOR.mjSENS_JOINTVEL: SensorReader.joint_speed,
    _SENSOR.mjSENS_ACTUATORFRC: SensorReader.actuator_force,
    _SENSOR.mjSENS_JOINTACTFRC: SensorReader.joint_actuator_force,
    _SENSOR.mjSENS_TOUCH: SensorReader.touch,
    _SENSOR.mjSENS_FRAMEPOS: SensorReader.frame_position,
    _SENSOR.mjSENS_FRAMEQUAT: SensorReader.frame_quaternion,
    **dict.fromkeys(_AXES, SensorReader.frame_axis),
    _SENSOR.mjSENS_FRAMELINVEL: SensorReader.frame_velocity,
    _SENSOR.mjSENS_FRAMEANGVEL: SensorReader.frame_spin,
    _SENSOR.mjSENS_VELOCIMETER: SensorReader.velocimeter,
    _SENSOR.mjSENS_GYRO: SensorReader.gyro,
    _SENSOR.mjSENS_ACCELEROMETER: SensorReader.accelerometer,
    _SENSOR.mjSENS_SUBTREECOM: SensorReader.subtree_centre,
    _SENSOR.mjSENS_SUBTREELINVEL: SensorReader.subtree_velocity,
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
