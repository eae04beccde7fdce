"""Whether the simulator's own time step is what makes it differ."""

from __future__ import annotations

from typing import Any

from estexp_jax.discovery.selection import Selection, p_value
from estexp_jax.physics.changes import Change
from estexp_jax.physics.effects.time_step import TimeStep

_PLAIN = 0.022
"""An error over the readings' range (nrmse) below which steps cause what they cause everywhere."""
_ALONE = 0.3
"""Share of the nominal simulator's error that may remain once its step's error is taken out."""


def step_to_blame(selection: Selection, nominal: float, timestep: float) -> Change | None:
    """The time step at which the mismatch vanishes, where the step makes most of a plain mismatch; else None.

    The error grows in proportion to the step, so it falls to the noise at the step over its size in deviations.

    Args:
        selection: what was tried; nothing was claimed.
        nominal: error of the nominal simulator on the training windows, an nrmse.
        timestep: its step, s.
    """
    if nominal < _PLAIN or selection.corrected.error > _ALONE * selection.nominal.error:
        return None
    return Change("time_step", None, {"step": timestep / selection.nominal.error})


def step_entry(change: Change) -> dict[str, Any]:
    """Its entry in `what`. No interval: the step is a rule, not a measurement."""
    step = {"value": change.parameters["step"], "low": None, "high": None, "unit": "s"}
    e = TimeStep()
    return {
        "effect": e.name,
        "kind": e.kind,
        "name": None,
        "probability": 1.0,
        "in_mjcf": True,
        "sentence": e.sentence("", change.parameters),
        "equation": e.equation,
        "parameters": {"step": step},
    }


def step_place(selection: Selection) -> dict[str, Any]:
    """Its entry in `where`."""
    share = 1.0 - selection.corrected.held_out.sum() / selection.nominal.held_out.sum()
    p = p_value(selection.corrected, selection.nominal)
    return {"kind": "numerics", "name": None, "share": float(share), "p_value": p}
