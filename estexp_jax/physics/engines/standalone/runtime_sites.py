"""What a law sees of the place where it acts: the second part of every `explained.py`, for NumPy and JAX alike."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import mujoco
import numpy

from estexp_jax.physics.engines.standalone.runtime import LawPlace

_TENSOR = ((0, 3, 4), (3, 1, 5), (4, 5, 2))
"""Columns of MuJoCo's composite inertias that make a matrix; after them come the first moment, and the mass."""


class Carried(NamedTuple):
    """Momenta (..., nv, 3) that unit speeds of degrees of freedom give; composite inertias; where bodies are."""

    linear: Any
    angular: Any
    inertia: Any
    centre: Any
    place: Any


def carried(np: Any, model: mujoco.MjModel, crb: Any, cdof: Any, centre: Any, place: Any) -> Carried:
    """Of arrays that MuJoCo computes of a configuration."""
    angular, linear = _momentum(np, crb[..., model.dof_bodyid, :], cdof[..., :3], cdof[..., 3:])
    return Carried(linear, angular, crb, centre, place)


def _momentum(np: Any, inertia: Any, spin: Any, speed: Any) -> tuple[Any, Any]:
    first, mass = inertia[..., 6:9], inertia[..., 9:10]
    rows = [np.sum(inertia[..., numpy.array(row)] * spin, axis=-1) for row in _TENSOR]
    return np.stack(rows, axis=-1) + np.cross(first, speed), mass * speed - np.cross(first, spin)


class Motion(NamedTuple):
    """A robot at the beginning of a step."""

    qpos: Any
    qvel: Any
    ctrl: Any
    on: Any  #: (..., nactuator) 1.0 where the motor is on
    dt: Any
    carried: Callable[[], Carried]
    xipos: Callable[[], Any]


class Site:
    """A joint, its motors and what moves there, at the beginning of a step.

    Attributes:
        q, w: position and speed.
        on: 1.0 where a motor is on.
        dt: length of the step, s.
        limit: largest torque of the motors.
        armature: of the joint.
    """

    def __init__(self, step: Any, place: LawPlace) -> None:
        self.step, self.there, self.np = step, place, step.np
        self.q, self.w = step.at(place.joint)
        self.motors = [step.find("actuator", name) for name in place.motors]
        self.on = 0.0 * self.q
        for a in self.motors:
            self.on = step.np.maximum(self.on, step.now.on[..., a])
        self.dt, self.limit = step.now.dt, place.limit
        dof = step.dof_of(place.joint)
        self.armature = step.read("dof_armature")[..., dof] + step.added["inertia"].get(dof, 0.0)

    @property
    def torque(self) -> Any:
        """Torque of the motors on the joint."""
        return self.torque_at(self.q, self.w)

    def torque_at(self, q: Any, w: Any) -> Any:
        """Torque of the motors, if they sat at a position and turned at a speed."""
        total = 0.0 * q
        for a in self.motors:
            total = total + self.step.torque(a, q, w)
        return self.step.within_joint(self.there.joint, total) if self.there.whole and self.motors else total

    def asked(self) -> tuple[Any, Any]:
        """Torque that the command asks for, in all and beyond rest."""
        step, total, beyond = self.step, 0.0 * self.q, 0.0 * self.q
        for a in self.motors:
            strength = step.scale(a) * step.gear(a) * step.read("actuator_gainprm")[..., a, 0]
            total = total + strength * step.command(a)
            beyond = beyond + strength * (step.command(a) - step.idle(a, self.q, self.w))
        return total, beyond

    def torque_of(self, number: float) -> Any:
        """Torque of the motors of another joint, given as 1 + its index in the nominal model."""
        total = 0.0 * self.q
        joint = self._joint(number)
        if not joint:
            return total
        q, w = self.step.at(joint)
        for motor, own in self.step.found.motors:
            if own == joint:
                total = total + self.step.torque(self.step.find("actuator", motor), q, w)
        return self.step.within_joint(joint, total)

    def motion_of(self, number: float) -> tuple[Any, Any]:
        """Position and speed of another joint."""
        joint = self._joint(number)
        return self.step.at(joint) if joint else (0.0 * self.q, 0.0 * self.q)

    def load(self) -> Any:
        """Sum of the sizes of all motors' torques."""
        total = 0.0 * self.q
        for motor, joint in self.step.found.motors:
            a = self.step.find("actuator", motor)
            total = total + abs(self.step.torque(a, *self.step.at(joint)))
        return total

    def gravity(self) -> Any:
        """Torque of gravity on the joint."""
        pull = self.step.now.carried().linear[..., self.step.dof_of(self.there.joint), :]
        return (pull * self.step.read("opt.gravity")).sum(-1)

    def mount(self) -> tuple[Any, ...]:
        """The body at the place, about the origin O of its frame: 21 where_of.

        Momentum about O that unit speed of the joint gives; force on the joint for each m/s2; momentum about O of all
        speeds; inertia xx, yy, zz, xy, xz, yz about O; mass times the way to the centre of mass; gravity.
        """
        np, model, there = self.np, self.step.model, self.step.now.carried()
        body, dof = self.step.find("body", self.there.body), self.step.dof_of(self.there.joint)
        arm = there.centre[..., int(model.body_rootid[body]), :] - there.place[..., body, :]
        coupling = there.angular + np.cross(arm[..., None, :], there.linear)
        inside = numpy.array([body in _ancestors(model, int(b)) for b in model.dof_bodyid], float)
        momentum = (coupling * (inside * self.step.now.qvel)[..., None]).sum(-2)
        whole, columns = there.inertia[..., body, :], []
        for axis in numpy.eye(3):
            n, f = _momentum(np, whole, axis, np.cross(axis, arm))
            columns.append(n + np.cross(arm, f))
        six = [columns[j][..., i] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
        first = whole[..., 6:9] + whole[..., 9:10] * arm
        gravity = self.step.read("opt.gravity") + 0.0 * first
        parts = coupling[..., dof, :], there.linear[..., dof, :], momentum
        before = [part[..., i] for part in parts for i in range(3)]
        return *before, *six, *(part[..., i] for part in (first, gravity) for i in range(3))

    def _joint(self, number: float) -> str:
        k = round(number)
        return self.step.found.joints[k - 1] if k > 0 else ""


def _ancestors(model: mujoco.MjModel, body: int) -> set[int]:
    found = {body}
    while body:
        body = int(model.body_parentid[body])
        found.add(body)
    return found
