"""Springs and dampers written into descriptions, beside those that a joint has: MuJoCo 4's have up to three degrees."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np
from numpy.polynomial import Polynomial

from estexp_jax.physics.effects.sites import angle_unit
from estexp_jax.physics.model.robot import Robot, spec_element


def add_damper(robot: Robot, spec: mujoco.MjSpec, joint: str, coefficients: Sequence[float]) -> None:
    """Let a joint brake by (b + c |w| + d w^2) w more, of coefficients (b, c, d)."""
    there = spec_element(spec, robot, "joint", joint)
    there.damping = (np.asarray(there.damping) + np.asarray(coefficients)).tolist()


def add_spring(robot: Robot, spec: mujoco.MjSpec, joint: str, coefficients: Sequence[float], rest: float) -> None:
    """Let a joint be pulled by k x + l x^2 + m x^3 more, x its way from `rest`, of coefficients (k, l, m).

    Two springs side by side are one spring about a position where they balance; where there is none, where they pull
    least, without that pull.

    Args:
        robot: the nominal robot.
        spec: its description.
        joint: the joint's name.
        coefficients: of the spring, N m/rad^n or N/m^n.
        rest: rad or m.
    """
    there, unit = spec_element(spec, robot, "joint", joint), angle_unit(robot, spec, joint)
    before = float(there.springref) * unit
    own, more = Polynomial([0.0, *there.stiffness]), Polynomial([0.0, *coefficients])
    total = (own(Polynomial([-before, 1.0])) + more(Polynomial([-rest, 1.0]))).trim()
    balance = total.roots()
    if not len(balance):
        return
    wanted = before if any(there.stiffness) else rest
    order = np.lexsort([np.abs(balance.real - wanted), np.abs(balance.imag) > 1e-6 * np.maximum(np.abs(balance), 1.0)])
    middle = float(balance.real[order[0]])
    centred = total(Polynomial([middle, 1.0])).coef[1:4]
    there.stiffness = [*centred.tolist(), 0.0, 0.0][:3]
    there.springref = middle / unit
