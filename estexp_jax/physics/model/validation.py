"""Checks of a compiled model, since MuJoCo itself accepts NaN and infinities."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import mujoco
import numpy as np

from estexp_jax.errors import InputError

SHORTEST, LONGEST = 1e-6, 1.0
"""Bounds of the step, s: a shorter one never gets anywhere, a longer one jumps over every motion."""
BLOWN_UP = [
    int(kind)
    for kind in (mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL, mujoco.mjtWarning.mjWARN_BADQACC)
]
"""Warnings with which MuJoCo gives a simulation up."""
_MOST_READINGS, _MOST_KEPT, _MOST_ACTIVATIONS, _MOST_ITERATIONS = 100_000, 1_000_000, 10_000, 10_000
_VALUES_A_SLOT, _VALUES_A_RAY = 17, 12
"""Of a contact sensor and of a rangefinder at a camera, with all that they can tell of a contact or a pixel."""
_ITERATIONS = ("iterations", "ls_iterations", "noslip_iterations", "ccd_iterations", "sdf_iterations", "sdf_initpoints")
_FIELDS = (
    *("body_mass", "body_inertia", "body_pos", "body_quat", "body_ipos", "jnt_axis", "jnt_pos", "jnt_range"),
    *("jnt_stiffness", "dof_armature", "dof_damping", "dof_frictionloss", "geom_size", "geom_pos"),
    *("geom_friction", "qpos0", "key_qpos", "actuator_gear", "actuator_gainprm", "actuator_biasprm"),
    *("actuator_ctrlrange", "actuator_forcerange"),
)  # fmt: skip


def refuse_invalid(model: mujoco.MjModel, source: str) -> None:
    """See that a model's numbers are numbers, and its step one that can be taken.

    Args:
        model: compiled.
        source: where it came from, for messages.

    Raises:
        InputError: they are not.
    """
    step = float(model.opt.timestep)
    if not SHORTEST <= step <= LONGEST:
        right = f"{SHORTEST:g} to {LONGEST:g} s"
        raise InputError(f"a step of {step:g} s cannot be simulated", where=f"{source}, <option> timestep", right=right)
    if not np.all(np.isfinite(model.opt.gravity)):
        raise InputError(f"gravity is {model.opt.gravity}", where=f"{source}, <option> gravity", right="three numbers")
    for field in _FIELDS:
        if not np.all(np.abs(getattr(model, field)) < 1e30):  # as MuJoCo's own limit of what counts as a number
            raise InputError(f"{field} holds what is no number or beyond 1e30", where=source, right="finite numbers")
    _refuse_massless(model, source)


def _refuse_massless(model: mujoco.MjModel, source: str) -> None:
    """See that every joint moves something, and no two the same: else no force tells an acceleration."""
    data = mujoco.MjData(model)
    with warnings_suppressed():
        mujoco.mj_forward(model, data)
    warned = data.warning[int(mujoco.mjtWarning.mjWARN_INERTIA)]
    if warned.number:
        joint = int(model.dof_jntid[warned.lastinfo])
        name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_JOINT, joint) or f"joint_{joint}"
        right = "give its body mass and inertia, or the joint armature; two joints must not move alike"
        raise InputError(f"the inertia matrix is singular at the joint '{name}'", where=source, right=right)


def refuse_unbounded(spec: mujoco.MjSpec, source: str) -> None:
    """See that a description claims no more than a robot has, in sum, before memory and time are taken for it.

    Raises:
        InputError: it does.
    """
    claims = {
        "values of sensors": (sum(map(_values_of(spec), spec.sensors)), _MOST_READINGS),
        "kept values of sensors and actuators": (_kept(spec), _MOST_KEPT),
        "activations of actuators": (sum(max(int(a.actdim), 0) for a in spec.actuators), _MOST_ACTIVATIONS),
        "custom numbers": (sum(max(int(n.size), 0) for n in spec.numerics), _MOST_KEPT),
        "iterations of a solver": (max(int(getattr(spec.option, name)) for name in _ITERATIONS), _MOST_ITERATIONS),
    }
    for what, (claimed, most) in claims.items():
        if claimed > most:
            raise InputError(f"claims {claimed:,} {what}", where=source, right=f"at most {most:,}")


def _values_of(spec: mujoco.MjSpec) -> Callable[[Any], int]:
    """Gives the most values that a sensor may have, where its XML decides."""
    pixels = {camera.name: int(np.prod(np.maximum(camera.resolution, 1), dtype=float)) for camera in spec.cameras}

    def most(sensor: Any) -> int:
        if sensor.type == mujoco.mjtSensor.mjSENS_USER:
            return int(sensor.dim)
        if sensor.type == mujoco.mjtSensor.mjSENS_CONTACT:
            return _VALUES_A_SLOT * max(int(sensor.intprm[2]), 1)
        if sensor.type == mujoco.mjtSensor.mjSENS_RANGEFINDER:
            return _VALUES_A_RAY * pixels.get(sensor.objname, 1)
        return 1

    return most


def _kept(spec: mujoco.MjSpec) -> int:
    """How many earlier values delayed sensors and actuators keep."""
    of_sensor = _values_of(spec)
    sensors = sum(max(int(s.nsample), 0) * (1 + of_sensor(s)) for s in spec.sensors)
    return sensors + sum(2 * max(int(a.nsample), 0) for a in spec.actuators)


@contextmanager
def warnings_suppressed() -> Iterator[None]:
    """Suppresses warnings while a model is read, so that each problem is reported once."""
    with mujoco_warnings_suppressed(), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


@contextmanager
def mujoco_warnings_suppressed() -> Iterator[None]:
    """MuJoCo's warnings, such as of a simulation that diverges, kept from stderr and from a MUJOCO_LOG.TXT."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(_ignore)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)


def _ignore(_: str) -> None:
    pass
