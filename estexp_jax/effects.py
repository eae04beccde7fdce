# ruff: noqa: E402 (XLA is told to be quiet before JAX is imported)
"""Effects: those that the program knows, and all that is needed to write one of your own.

`estexp_jax.effects()` lists them. A class of your own is made known with `register`, as a decorator or called; see the
page on writing an effect.
"""

from __future__ import annotations

import sys
from types import ModuleType

from estexp_jax.runs.compilation_cache import quiet_xla

quiet_xla()

from estexp_jax.api.effects import EffectList, effects, register
from estexp_jax.physics.effects.base import (
    NEVER,
    Array,
    Arrays,
    BodyForce,
    CommandLaw,
    CommandShift,
    Distortion,
    Edit,
    Effect,
    JointForce,
    JointState,
    Parameter,
    ReadingDrift,
    ReadingShift,
    Term,
)
from estexp_jax.physics.effects.damage import Amounts, Damage, ModelError
from estexp_jax.physics.effects.guesses import Bounds, Vectors
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.sites import (
    actuator_sites,
    body_sites,
    driven_joint_sites,
    joint_dofs,
    scalar_joint_sites,
    scalar_sensor_sites,
)
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording

__all__ = [
    "NEVER",
    "Amounts",
    "Array",
    "Arrays",
    "BodyForce",
    "Bounds",
    "CommandLaw",
    "CommandShift",
    "Damage",
    "Distortion",
    "Edit",
    "Effect",
    "EffectList",
    "JointForce",
    "JointState",
    "ModelError",
    "Observed",
    "Parameter",
    "ReadingDrift",
    "ReadingShift",
    "Recording",
    "Robot",
    "Term",
    "Vectors",
    "actuator_sites",
    "body_sites",
    "driven_joint_sites",
    "effects",
    "joint_dofs",
    "register",
    "scalar_joint_sites",
    "scalar_sensor_sites",
    "scales",
]


class _Namespace(ModuleType):
    """This module, which lists all effects when called: importing it puts it in the place of the function."""

    def __call__(self) -> EffectList:
        return effects()


sys.modules[__name__].__class__ = _Namespace
