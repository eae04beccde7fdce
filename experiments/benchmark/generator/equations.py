"""Equations of motion of the planar arm and the cart-pole, by hand from their Lagrangians; scipy integrates them.

Both turn about +y, so a vector (x, z) fixed to a link at angle q is

    R(q) (x, z) = (x cos q + z sin q, z cos q - x sin q).

Joints add damping, friction loss is smoothed over 1e-3 rad/s, and armature stands on the diagonal of the mass matrix.
"""

from __future__ import annotations

from collections.abc import Callable
from math import cos, sin, tanh

import mujoco
import numpy as np
from scipy.integrate import ode

Vector = tuple[float, float]


def turned(v: Vector, q: float) -> Vector:
    """R(q) v."""
    return v[0] * cos(q) + v[1] * sin(q), v[1] * cos(q) - v[0] * sin(q)


def derived(v: Vector, q: float) -> Vector:
    """dR(q)/dq v, which is R(q) v turned by a quarter."""
    x, z = turned(v, q)
    return z, -x


def dot(a: Vector, b: Vector) -> float:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1]


class _Planar:
    """What both robots share: numbers of a compiled model in the x-z plane."""

    def __init__(self, model: mujoco.MjModel) -> None:
        self.mass = [float(model.body_mass[b]) for b in (1, 2)]
        self.com = [(float(model.body_ipos[b, 0]), float(model.body_ipos[b, 2])) for b in (1, 2)]
        self.inertia = [_about_y(model, b) for b in (1, 2)]
        self.offset = (float(model.body_pos[2, 0]), float(model.body_pos[2, 2]))
        self.mounted = [2.0 * float(np.arctan2(model.body_quat[b, 2], model.body_quat[b, 0])) for b in (1, 2)]
        self.gravity = (float(model.opt.gravity[0]), float(model.opt.gravity[2]))
        self.damping, self.friction = model.dof_damping.tolist(), model.dof_frictionloss.tolist()
        self.armature = model.dof_armature.tolist()

    def resisted(self, i: int, w: float) -> float:
        """Damping and dry friction of a joint."""
        return -self.damping[i] * w - self.friction[i] * tanh(w / 1e-3)


class Arm(_Planar):
    """Two links: M(q) w' = force - h(q, w) + gravity, from L = sum (m |v|^2 + I w^2) / 2 + sum m g p."""

    def acceleration(self, q: list[float], w: list[float], force: list[float]) -> Vector:
        """w' of both joints."""
        first, second = q[0] + self.mounted[0], q[1] + self.mounted[1]
        c1, c2, l1 = self.com[0], self.com[1], self.offset
        m1, m2 = self.mass
        reach = dot(l1, turned(c2, second))
        bend = m2 * dot(l1, derived(c2, second))
        m22 = self.inertia[1] + m2 * dot(c2, c2)
        m12 = m22 + m2 * reach
        m11 = self.inertia[0] + m1 * dot(c1, c1) + m12 + m2 * (dot(l1, l1) + reach)
        g = self.gravity
        pull2 = m2 * dot(g, derived(c2, first + second))
        pull1 = m1 * dot(g, derived(c1, first)) + m2 * dot(g, derived(l1, first)) + pull2
        b1 = force[0] + self.resisted(0, w[0]) + pull1 - bend * (2.0 * w[0] * w[1] + w[1] * w[1])
        b2 = force[1] + self.resisted(1, w[1]) + pull2 + bend * w[0] * w[0]
        return _solved(m11 + self.armature[0], m12, m22 + self.armature[1], b1, b2)


class CartPole(_Planar):
    """A cart on a rail along x and a pole that hangs from it."""

    def acceleration(self, q: list[float], w: list[float], force: list[float]) -> Vector:
        """Of the cart, and w' of the pole."""
        angle, (mc, mp) = q[1] + self.mounted[1], self.mass
        c, slope = self.com[1], derived(self.com[1], q[1] + self.mounted[1])
        curve = turned(c, angle)
        m22 = self.inertia[1] + mp * dot(c, c)
        b1 = force[0] + self.resisted(0, w[0]) + (mc + mp) * self.gravity[0] + mp * curve[0] * w[1] * w[1]
        b2 = force[1] + self.resisted(1, w[1]) + mp * dot(self.gravity, slope)
        return _solved(mc + mp + self.armature[0], mp * slope[0], m22 + self.armature[1], b1, b2)


def by_hand(model: mujoco.MjModel, name: str) -> Arm | CartPole:
    """The written-out equations of a robot, with the numbers of a compiled model."""
    return {"planar": Arm, "cartpole": CartPole}[name](model)


def integrator(equations: Callable[[], Arm | CartPole], force: list[float]) -> ode:
    """An adaptive Runge-Kutta integrator (Dormand and Prince, order 8) of (q, w) under a force that may be changed."""

    def slope(_: float, y: np.ndarray) -> list[float]:
        q0, q1, w0, w1 = y.tolist()
        a = equations().acceleration([q0, q1], [w0, w1], force)
        return [w0, w1, a[0], a[1]]

    return ode(slope).set_integrator("dop853", rtol=1e-7, atol=1e-9)


def _about_y(model: mujoco.MjModel, body: int) -> float:
    """Moment of inertia of a body about +y through its centre of mass."""
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, model.body_iquat[body])
    return float(rotation.reshape(3, 3)[1] ** 2 @ model.body_inertia[body])


def _solved(m11: float, m12: float, m22: float, b1: float, b2: float) -> Vector:
    determinant = m11 * m22 - m12 * m12
    return (m22 * b1 - m12 * b2) / determinant, (m11 * b2 - m12 * b1) / determinant
