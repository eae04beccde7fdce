"""Springs and dampers beyond the first degree, which MuJoCo 4 has and MJX 3.17 has not.

A damper of coefficients (b, c, d) gives -(b + c |w| + d w^2) w, a spring of (k, l, m) -(k x + l x^2 + m x^3) of its
stretch x. What is beyond b and k is added here.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax.numpy as jnp
import mujoco
import numpy as np
from mujoco import mjx

_OFF, _JOINT = mujoco.mjtDisableBit, mujoco.mjtJoint


class Beyond(NamedTuple):
    """What is beyond the first degree: a force, and minus its derivative by the speed or the stretch."""

    force: Any
    slope: Any


def damper(square: Any, cube: Any, speed: Any) -> Beyond:
    """A damper's, of coefficients `square`, of |w| w, and `cube`, of w^3; arrays of one shape."""
    bare, power = jnp.abs(speed), speed * speed
    return Beyond(-(square * bare + cube * power) * speed, 2.0 * square * bare + 3.0 * cube * power)


def spring(square: Any, cube: Any, stretch: Any) -> Beyond:
    """A spring's, of coefficients `square` and `cube`; arrays of one shape."""
    return Beyond(-(square + cube * stretch) * stretch * stretch, (2.0 * square + 3.0 * cube * stretch) * stretch)


def with_polynomials(own: mujoco.MjModel, model: mjx.Model, qpos: Any, qvel: Any) -> tuple[mjx.Model, Any]:
    """A model and a force on its joints (nv,) that together act as all of the robot's springs and dampers do.

    Within a step each is its tangent: MuJoCo, too, takes a damper's derivative into account at the step's end, and
    Runge and Kutta's method evaluates both several times.

    Args:
        own: the nominal model.
        model: of one step.
        qpos: (nq,).
        qvel: (nv,).
    """
    force, off = jnp.zeros_like(qvel), own.opt.disableflags
    if np.any(own.dof_dampingpoly) and not off & _OFF.mjDSBL_DAMPER:
        square, cube = jnp.asarray(own.dof_dampingpoly, qvel.dtype).T
        more = damper(square, cube, qvel)
        model = model.replace(dof_damping=model.dof_damping + more.slope)
        force = force + more.force + more.slope * qvel
    if np.any(own.jnt_stiffnesspoly) and not off & _OFF.mjDSBL_SPRING:
        joints = np.flatnonzero(np.isin(own.jnt_type, (int(_JOINT.mjJNT_HINGE), int(_JOINT.mjJNT_SLIDE))))
        places, dofs = own.jnt_qposadr[joints], own.jnt_dofadr[joints]
        square, cube = jnp.asarray(own.jnt_stiffnesspoly[joints], qpos.dtype).T
        stretch = qpos[places] - own.qpos_spring[places]
        more = spring(square, cube, stretch)
        rest = qpos[places] - model.qpos_spring[places]
        model = model.replace(jnt_stiffness=model.jnt_stiffness.at[joints].add(more.slope))
        force = force.at[dofs].add(more.force + more.slope * rest)
    return model, force
