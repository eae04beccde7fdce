"""Whether MJX simulates what a change writes into MJCF: it passes over much of MuJoCo 4 in silence."""

from __future__ import annotations

from collections.abc import Mapping

import mujoco
import numpy as np

from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.effects.written import mjcf_refusal, written
from estexp_jax.physics.model.robot import Robot

_IGNORED: Mapping[str, str] = {
    "actuator_delay": "delays",
    "sensor_delay": "delays",
    "actuator_actearly": "activations that act at once",
    "actuator_damping": "damping of actuators",
    "actuator_dampingpoly": "damping of actuators",
    "actuator_armature": "armature of actuators",
    "dof_dampingpoly": "damping of several powers",
    "jnt_stiffnesspoly": "stiffness of several powers",
    "tendon_dampingpoly": "damping of several powers",
    "tendon_stiffnesspoly": "stiffness of several powers",
    "jnt_springyield": "springs that yield",
    "tendon_springyield": "springs that yield",
}
"""Fields that plain MJX 3.17 takes no notice of; they are 0, or endless, in a model that does not use them."""


def mjx_refusal(robot: Robot, change: Change) -> str:
    """Why MJCF has no place for a change of a robot that MJX simulates; empty where it has one."""
    if why := mjcf_refusal(robot, change):
        return why
    model, nominal = written(robot, [change]).compile(), robot.model
    if _unusual(model) > _unusual(nominal):
        return "MJX has no DC motors"
    ignored = (what for field, what in _IGNORED.items() if _used(model, field) > _used(nominal, field))
    what = next(ignored, "")
    return f"MJX ignores {what}" if what else ""


def _unusual(model: mujoco.MjModel) -> int:
    """Number of actuators that have not one input and one output."""
    return int(np.sum((model.actuator_ctrlnum != 1) | (model.actuator_outnum != 1)))


def _used(model: mujoco.MjModel, field: str) -> int:
    values = np.asarray(getattr(model, field))
    return int(np.sum(np.isfinite(values) & (values != 0)))
