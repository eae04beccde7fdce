"""Inputs of laws at their instances: the sites and lanes where an effect is at work, along the last axis."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from estexp_jax.physics.effects.base import Arrays, JointState
from estexp_jax.physics.effects.mounts import STILL, MountState
from estexp_jax.physics.engines.motors import asked_torques, limited_commands, motor_torque

OWN_ROWS = ("qpos", "qvel", "dt", "rotor_inertia", "gravity")
"""Parts of a step's table that a term sees of its own joint, in the order of its first rows."""


class MotorFields(NamedTuple):
    """Numbers of motors, named as in MuJoCo's model: arrays (motors, n, ...), for n instances."""

    actuator_gear: Any
    actuator_gainprm: Any
    actuator_biasprm: Any
    actuator_gaintype: Any
    actuator_biastype: Any
    actuator_forcelimited: Any
    actuator_forcerange: Any
    actuator_ctrllimited: Any
    actuator_ctrlrange: Any


class MotorState(NamedTuple):
    """State of motors, arrays (motors, n): commands, and by what their forces are multiplied (0 where off)."""

    ctrl: Any
    scale: Any


class SiteFields(NamedTuple):
    """What does not change at the sites of instances.

    Attributes:
        p: the effect's parameters, (n,) each.
        motors: of the motors that count at each site.
        there: (motors, n) 1.0 where there is such a motor.
        limited, limits: (n,), (n, 2) common limit of a joint's motors, where all of them are meant.
        limit: (n,) largest torque of the nominal motors.
    """

    p: Arrays
    motors: MotorFields
    there: Any
    limited: Any
    limits: Any
    limit: Any


class RobotFields(NamedTuple):
    """What does not change of the whole robots that instances are on, for laws that ask for another joint.

    Attributes:
        joint: (joints,) 1 + index of each hinge and slide.
        motors: of all motors that drive one.
        drives: (joints, motors) 1.0 where a motor drives a joint.
        limited, limits: (joints, n), (joints, n, 2) common limit of each joint's motors.
    """

    joint: Any
    motors: MotorFields
    drives: Any
    limited: Any
    limits: Any


class TermInputs(NamedTuple):
    """Instances of a term at the beginning of a step, (n,) each."""

    q: Any
    w: Any
    dt: Any
    armature: Any
    gravity: Any
    on: Any
    motors: MotorState
    mount: MountState
    state: Arrays

    @classmethod
    def of_rows(cls, x: Any, motors: int, there: Any, mounts: int) -> TermInputs:
        """From rows (rows, n): `OWN_ROWS`; of the motors commands, switches, shares; of a mount; hidden variables."""
        own, n = x[: len(OWN_ROWS)], len(OWN_ROWS)
        ctrl, on, share = (x[n + i * motors : n + (i + 1) * motors] for i in range(3))
        switched = jnp.max(on * there, axis=0) if motors else jnp.zeros_like(x[0])
        rest = tuple(x[n + 3 * motors :])
        q, w, dt, armature, gravity = own
        mount = mount_of_rows(rest[:mounts]) if mounts else STILL
        return cls(q, w, dt, armature, gravity, switched, MotorState(ctrl, on * share), mount, rest[mounts:])


class RobotInputs(NamedTuple):
    """Whole robots that instances are on at the beginning of a step: (joints, n) of hinges and slides, and motors."""

    q: Any
    w: Any
    motors: MotorState

    @classmethod
    def of_rows(cls, x: Any, joints: int, motors: int) -> RobotInputs:
        """From rows (rows, n): q and w of the joints; commands, switches and shares of the motors."""
        ctrl, on, share = (x[2 * joints + i * motors : 2 * joints + (i + 1) * motors] for i in range(3))
        return cls(x[:joints], x[joints : 2 * joints], MotorState(ctrl, on * share))


MOUNT_ROWS = 21
"""Numbers of a mount."""


def mount_of_rows(x: Sequence[Any]) -> MountState:
    """A mount of its numbers, one after the other."""
    coupling, arm, momentum, first, gravity = ((x[a], x[a + 1], x[a + 2]) for a in (0, 3, 6, 15, 18))
    xx, yy, zz, xy, xz, yz = x[9:15]
    return MountState(coupling, arm, momentum, (xx, yy, zz, xy, xz, yz), first, gravity)


@jax.jit  # traced once, although terms ask many times
def _torque(motors: MotorFields, state: MotorState, q: Any, w: Any) -> Any:
    """Torque (motors, n) of motors on their joints."""
    return state.scale * motor_torque(motors, ..., q, w, limited_commands(motors, state.ctrl))  # pyright: ignore[reportArgumentType]


def _picked(which: Any, x: Any) -> Any:
    """Of values (joints, n), those of one joint, (n,)."""
    chosen: Any = jnp.where(which, x, 0.0)
    return jnp.sum(chosen, axis=0)


def _clipped(limited: Any, limits: Any, torque: Any) -> Any:
    return jnp.where(limited, jnp.clip(torque, limits[..., 0], limits[..., 1]), torque)


def joint_state(site: SiteFields, now: TermInputs, robot: RobotFields | None, moving: RobotInputs | None) -> JointState:
    """What a term sees; of the whole robot only where it asks for other joints."""

    def torque_at(q: Any, w: Any) -> Any:
        if not len(site.there):
            return jnp.zeros_like(q)
        each: Any = _torque(site.motors, now.motors, q, w)
        return _clipped(site.limited, site.limits, jnp.sum(each * site.there, axis=0))

    def asked() -> tuple[Any, Any]:
        if not len(site.there):
            return jnp.zeros_like(now.q), jnp.zeros_like(now.q)
        command = limited_commands(site.motors, now.motors.ctrl)
        each: Any = asked_torques(site.motors, ..., now.q, now.w, command)  # pyright: ignore[reportArgumentType]
        in_all, beyond = (jnp.sum(x * now.motors.scale * site.there, axis=0) for x in each)
        return in_all, beyond

    def torque_of(number: Any) -> Any:
        assert robot is not None and moving is not None
        q, w = (robot.drives.T @ x for x in (moving.q, moving.w))
        each = _torque(robot.motors, moving.motors, q, w)
        torque: Any = _clipped(robot.limited, robot.limits, robot.drives @ each)
        return _picked(jnp.round(number) == robot.joint[:, None], torque)

    def load() -> Any:
        assert robot is not None and moving is not None
        q, w = (robot.drives.T @ x for x in (moving.q, moving.w))
        each: Any = jnp.abs(_torque(robot.motors, moving.motors, q, w))
        return jnp.sum(each, axis=0)

    def motion_of(number: Any) -> tuple[Any, Any]:
        assert robot is not None and moving is not None
        mine = jnp.round(number) == robot.joint[:, None]
        q, w = (_picked(mine, x) for x in (moving.q, moving.w))
        return q, w

    return JointState(
        q=now.q,
        w=now.w,
        torque=torque_at(now.q, now.w),
        on=now.on,
        dt=now.dt,
        limit=site.limit,
        armature=now.armature,
        torque_at=torque_at,
        torque_of=torque_of,
        motion_of=motion_of,
        asked=asked,
        load=load,
        gravity=lambda: now.gravity,
        mount=lambda: now.mount,
    )
