"""Constraints at the joints: stops and friction losses.

Source: MuJoCo documentation, "Computation": "Constraint model"; `engine_core_constraint.c`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import jax.numpy as jnp
import mujoco

from estexp_jax.lanes.algebra import Scalar, add, sub
from estexp_jax.lanes.layout import Joint, Layout
from estexp_jax.lanes.model_parameters import ModelParameters
from estexp_jax.lanes.rows import ContactPush, FrictionLoss, Rows
from estexp_jax.lanes.softness import Softness, regularised

_OFF = mujoco.mjtDisableBit


def limit_rows(
    layout: Layout, params: ModelParameters, qpos: Sequence[Sequence[Scalar]], qvel: Sequence[Scalar], dt: Scalar
) -> list[Rows]:
    """Each limited joint against the nearer of its stops.

    Args:
        layout: structure.
        params: of the robots.
        qpos: per joint.
        qvel: per degree of freedom.
        dt: length of the step, s.
    """
    if layout.model.opt.disableflags & (_OFF.mjDSBL_LIMIT | _OFF.mjDSBL_CONSTRAINT):
        return []
    return [
        _stop(layout, params, joint, q[0], qvel[joint.dofs[0]], dt)
        for joint, q in zip(layout.joints, qpos, strict=True)
        if joint.limited and not joint.free
    ]


def _stop(layout: Layout, params: ModelParameters, joint: Joint, q: Scalar, speed: Scalar, dt: Scalar) -> Rows:
    ids, dof = list(joint.ids), layout.dofs[joint.dofs[0]]
    low, high = (sub(q, params.get("jnt_range", ids, 0)), sub(params.get("jnt_range", ids, 1), q))
    sign = jnp.where(low < high, 1.0, -1.0).astype(q.dtype)
    violation = sub(jnp.minimum(low, high), params.get("jnt_margin", ids))
    ref = tuple(params.get("jnt_solref", ids, i) for i in range(2))
    soft = replace(Softness.of(params, layout.model.jnt_solref[ids], layout.model.jnt_solimp[ids]), ref=ref)
    impedance = soft.impedance(violation)
    spring, damper = soft.spring(dt, safe=_safe(layout))
    weight = params.get("dof_invweight0", dof.addresses)
    stiffness = jnp.where(violation < 0, regularised(weight, impedance), 0.0)
    return ContactPush(dof.k, (dof.index,), (sign,), stiffness, -damper * sign * speed - spring * impedance * violation)


def friction_loss_rows(
    layout: Layout, params: ModelParameters, speed: Sequence[Scalar], dt: Scalar, more: Sequence[Scalar]
) -> list[Rows]:
    """Friction losses; `speed` and `more`, what effects add to them, per degree of freedom."""
    model, rows = layout.model, []
    if model.opt.disableflags & (_OFF.mjDSBL_FRICTIONLOSS | _OFF.mjDSBL_CONSTRAINT):
        return rows
    for dof in layout.dofs:
        if dof.has_friction_loss:
            at = list(dof.addresses)
            soft = Softness.of(params, model.dof_solref[at], model.dof_solimp[at])
            _, damper = soft.spring(dt, safe=_safe(layout))
            impedance = soft.impedance(jnp.zeros_like(speed[dof.index]))
            stiffness = regularised(params.get("dof_invweight0", at), impedance)
            bound = add(params.get("dof_frictionloss", at), more[dof.index])
            rows.append(FrictionLoss(dof.k, dof.index, stiffness, bound, -damper * speed[dof.index]))
    return rows


def _safe(layout: Layout) -> bool:
    return not layout.model.opt.disableflags & _OFF.mjDSBL_REFSAFE
