"""Torques that gravity puts on hinges and slides, in lanes."""

from __future__ import annotations

from typing import Any

from estexp_jax.lanes.dynamics import Inertias, mass_and_bias
from estexp_jax.lanes.kinematics import body_motion
from estexp_jax.lanes.layout import Layout
from estexp_jax.lanes.model_parameters import ModelParameters
from estexp_jax.lanes.step import LaneState


def gravity_torques(layout: Layout, params: ModelParameters, state: LaneState) -> dict[int, Any]:
    """Torque of gravity (N,) on each degree of freedom, by its velocity address: the bias of robots that stand still.

    Args:
        layout: structure.
        params: of the robots.
        state: of the robots; speeds do not count.
    """
    still = body_motion(layout, params, state.qpos, [0] * len(layout.dofs))
    _, bias = mass_and_bias(layout, params, Inertias(layout, params), still)
    return {
        address: -(force[i] if len(dof.addresses) > 1 else force)
        for dof, force in zip(layout.dofs, bias, strict=True)
        for i, address in enumerate(dof.addresses)
    }
