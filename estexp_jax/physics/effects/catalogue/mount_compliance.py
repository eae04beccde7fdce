"""Mount compliance: the body that the model welds to the world moves, like a stand that gives."""

from collections.abc import Mapping, Sequence
from itertools import product
from typing import ClassVar, final

import jax.numpy as jnp
import mujoco
import numpy as np

from estexp_jax.physics.effects.base import (
    NEVER,
    Array,
    Arrays,
    DisplayedState,
    JointForce,
    JointState,
    Parameter,
    Term,
)
from estexp_jax.physics.effects.guesses import Vectors
from estexp_jax.physics.effects.mounts import (
    MountState,
    carried_joints,
    mount_sensors,
    mount_sites,
    solved,
    vector_product,
)
from estexp_jax.physics.effects.new_elements import free_name
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot, spec_element
from estexp_jax.physics.recording import Recording

_FREQUENCIES, _DAMPING = (0.7, 40.0), 1.5
"""Bounds of a mount's own frequency, Hz, and of its damping as a share of the critical one."""
_TRIED = (2.0, 5.0, 10.0, 20.0), (0.05, 0.25)
"""Frequencies, Hz, and shares of the critical damping that a search starts from."""
_TILT, _RATE, _CHANGE, _MOMENTUM, _STEP = slice(0, 3), slice(3, 6), slice(6, 9), slice(9, 12), 12
"""Hidden variables: the tilt, rad, its speed, its acceleration, the angular momentum, and the step before, s."""


@register_effect
@final
class MountCompliance(Term):
    """The body turns about the origin of its frame by a small tilt x, in all directions alike.

    d/dt (J x' + h) = -k x - d x' + r m x (g - x x g): with J the inertia of the body and all that it carries, h the
    angular momentum of the joints' speeds, all about the origin. It is integrated by the trapezoidal rule, from the
    momentum, so that recorded speeds are enough to know the tilt. On its joints act what the tilt changes in gravity
    and, a step late, the inertia of what turns with the body. Terms of the second order in x are left out.
    """

    name: ClassVar[str] = "mount_compliance"
    kind: ClassVar[str] = "body"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("k", "N m/rad", neutral=NEVER),
        Parameter("d", "N m s/rad"),
    )
    equation: ClassVar[str] = "J dv/dt = -k x - d v + moment of what the body carries, dx/dt = v, x its tilt"
    in_mjcf: ClassVar[bool] = True
    extends_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "flexible base: Siciliano and Khatib, Springer Handbook of Robotics (2008), section 13.3"
    n_states: ClassVar[int] = 13

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return mount_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        stiff = [min(_stiffness(robot, site, f), 0.9 * NEVER) for f in _FREQUENCIES]
        return (stiff[0], stiff[1]), (0.0, _damping(robot, site, _FREQUENCIES[1], _DAMPING))

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return (
            f"the body {site}, which the model welds, gives: it tilts about its origin against "
            f"{values['k']:.3g} N m/rad and {values['d']:.3g} N m s/rad"
        )

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        return [(_stiffness(robot, site, f), _damping(robot, site, f, share)) for f, share in product(*_TRIED)]

    def advice(self, recordings: Sequence[Recording]) -> tuple[str, ...]:
        return (
            "Record fast swings of heavy parts with a gyroscope on the body that should stand still: if it moves, "
            "stiffen its mount or give the model a joint there.",
        )

    def displayed(self, robot: Robot) -> Sequence[DisplayedState]:
        found, row = list[DisplayedState](), 0
        for site in self.sites(robot):
            for sensor in mount_sensors(robot, site):
                for i, axis in enumerate(sensor.axes):
                    shares = _in_sensor(axis, sensor.arm, robot.model.opt.gravity) if sensor.accelerates else {3: axis}
                    found += [
                        DisplayedState(sensor.column + i, first + e, row, float(share[e]))
                        for first, share in shares.items()
                        for e in range(3)
                    ]
            row += len(carried_joints(robot, site))
        return found

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        k, d = p
        there = joint.mount()
        x, rate, change, momentum = _turned(k, d, there, state)
        gives = k < NEVER
        tilted = vector_product((x[0], x[1], x[2]), there.gravity)
        force = sum(-c * a - g * t for c, a, g, t in zip(there.coupling, change, there.arm, tilted, strict=True))
        after = (*x, *rate, *change, *momentum, joint.dt + jnp.zeros_like(k))
        return JointForce(force=jnp.where(gives, force, 0.0)), tuple(jnp.where(gives, a, 0.0) for a in after)

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        body = spec_element(spec, robot, "body", site)
        joint = body.add_joint(name=free_name([j.name for j in spec.joints], f"{site}_mount"))
        joint.type, joint.limited = mujoco.mjtJoint.mjJNT_BALL, mujoco.mjtLimited.mjLIMITED_FALSE
        joint.stiffness, joint.damping = [values["k"], 0.0, 0.0], [values["d"], 0.0, 0.0]
        joint.armature, joint.frictionloss, joint.springdamper = 0.0, 0.0, [0.0, 0.0]
        weld, names = robot.model.body_weldid, robot.names("body")
        moving = [b for b in robot.subtree(robot.index("body", site)) if weld[b] == 0]
        still = [b for b in range(robot.model.nbody) if weld[b] == 0 and b not in moving]
        for one, other in product(still, moving):  # what is welded together does not touch
            spec.add_exclude(bodyname1=names[one], bodyname2=names[other])


def _turned(k: Array, d: Array, there: MountState, state: Arrays) -> tuple[Arrays, Arrays, Arrays, Arrays]:
    """Tilt, its speed and acceleration, and the angular momentum now, from what they were a step ago."""
    (tx, ty, tz), rate, momentum, dt = state[_TILT], state[_RATE], state[_MOMENTUM], state[_STEP]
    x = (tx, ty, tz)
    begins = dt == 0.0
    pull = vector_product(there.first, there.gravity)
    still = tuple(m / k for m in pull)
    tilted = vector_product(x, there.gravity)
    pulled = tuple(m - t for m, t in zip(pull, vector_product(there.first, tilted), strict=True))
    half = 0.5 * dt
    known = [
        p - h + half * (2.0 * m - k * (2.0 * a + half * w) - d * w)
        for p, h, m, a, w in zip(momentum, there.momentum, pulled, x, rate, strict=True)
    ]
    held = half * (d + half * k)
    j = there.inertia
    turns = solved((j[0] + held, j[1] + held, j[2] + held, j[3], j[4], j[5]), (known[0], known[1], known[2]))
    after = tuple(jnp.where(begins, 0.0, w) for w in turns)
    tilt = tuple(
        jnp.where(begins, s, a + half * (before + now)) for s, a, before, now in zip(still, x, rate, after, strict=True)
    )
    change = tuple((now - before) / jnp.where(begins, 1.0, dt) for before, now in zip(rate, after, strict=True))
    change = tuple(jnp.where(begins, 0.0, c) for c in change)
    xx, yy, zz, xy, xz, yz = j
    rows = (xx, xy, xz), (xy, yy, yz), (xz, yz, zz)
    total = tuple(
        h + a * after[0] + b * after[1] + c * after[2] for h, (a, b, c) in zip(there.momentum, rows, strict=True)
    )
    return tilt, after, change, total


def _in_sensor(axis: np.ndarray, arm: np.ndarray, gravity: np.ndarray) -> dict[int, np.ndarray]:
    """What an accelerometer shows along an axis, by the first of three hidden variables: tilt, and its acceleration.

    It turns with the body, so that gravity seems to turn: x x g; and it accelerates: x'' x arm.
    """
    return {0: np.cross(gravity, axis), 6: np.cross(arm, axis)}


def _inertia(robot: Robot, body: str) -> float:
    return scales.carried_inertia(robot, robot.index("body", body))


def _stiffness(robot: Robot, body: str, frequency: float) -> float:
    return _inertia(robot, body) * (2.0 * np.pi * frequency) ** 2


def _damping(robot: Robot, body: str, frequency: float, share: float) -> float:
    return 2.0 * share * _inertia(robot, body) * 2.0 * np.pi * frequency
