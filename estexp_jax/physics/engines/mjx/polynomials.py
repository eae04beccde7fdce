"""Springs and dampers beyond the first degree, which MuJoCo 4 has and MJX 3.17 has not."""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp
import mujoco
import numpy as np
from mujoco import mjx

from estexp_jax.lanes.polynomials import damper, spring

_OFF, _JOINT = mujoco.mjtDisableBit, mujoco.mjtJoint


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
