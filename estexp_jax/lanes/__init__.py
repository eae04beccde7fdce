"""Populations of robots stepped with the robots as last axis of every array; see `README.md` beside this file.

The one place where code is not written for one robot and batched outside: with the batch last, each elementwise
operation runs over contiguous robots, and XLA makes vector code of it. Solves the same convex problem as MuJoCo.

The names below are the front of the package, each loaded at its first use.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from estexp_jax.lanes.capabilities import refusal
    from estexp_jax.lanes.compilation import compile_lowered, lower
    from estexp_jax.lanes.forces import MotorCommands, motor_commands
    from estexp_jax.lanes.layout import Layout, layout_of
    from estexp_jax.lanes.model_parameters import ModelParameters
    from estexp_jax.lanes.sensors import SensorReader
    from estexp_jax.lanes.states import from_lanes, to_lanes
    from estexp_jax.lanes.step import TOLERANCE, AddedForces, LaneState, Stepper

_HOMES = {
    "refusal": "capabilities",
    "compile_lowered": "compilation",
    "lower": "compilation",
    "MotorCommands": "forces",
    "motor_commands": "forces",
    "Layout": "layout",
    "layout_of": "layout",
    "ModelParameters": "model_parameters",
    "SensorReader": "sensors",
    "from_lanes": "states",
    "to_lanes": "states",
    "TOLERANCE": "step",
    "AddedForces": "step",
    "LaneState": "step",
    "Stepper": "step",
}
"""Module of each name of the front."""

__all__ = [
    "TOLERANCE",
    "AddedForces",
    "LaneState",
    "Layout",
    "ModelParameters",
    "MotorCommands",
    "SensorReader",
    "Stepper",
    "compile_lowered",
    "from_lanes",
    "layout_of",
    "lower",
    "motor_commands",
    "refusal",
    "to_lanes",
]


def __getattr__(name: str) -> Any:
    """A name of the front, from its module."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *_HOMES])
