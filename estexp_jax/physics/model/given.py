"""A robot from whatever a caller from Python holds: a path, MJCF text, a description, a compiled model, a robot."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import mujoco
import numpy as np

from estexp_jax.errors import InputError, abbreviated
from estexp_jax.physics.model.robot import Robot

ModelLike = str | os.PathLike[str] | mujoco.MjSpec | mujoco.MjModel | Robot
"""A model as Python gives it; see `robot_of`."""
_RIGHT = "a path of an MJCF or URDF, MJCF text, a mujoco.MjSpec, a mujoco.MjModel, or an ee.Robot"


def robot_of(model: ModelLike, root: str | Path | None = None) -> Robot:
    """A robot.

    Args:
        model: path of an MJCF or URDF, MJCF text (it begins with `<`), a description, a compiled model, or a robot.
        root: folder under which a model that is a path finds its files.

    Raises:
        InputError: it is none of these or does not compile; or a compiled model whose MJCF MuJoCo no longer has.
    """
    if isinstance(model, Robot):
        return model
    if isinstance(model, mujoco.MjSpec):
        return Robot.from_spec(model.copy())
    if isinstance(model, mujoco.MjModel):
        return _decompiled(model)
    if isinstance(model, str) and model.lstrip().startswith("<"):
        return Robot.from_string(model)
    if isinstance(model, str | os.PathLike):
        return Robot.from_xml(os.fspath(model), root)
    raise InputError(f"is {abbreviated(type(model).__name__)}, not a model", where="model", right=_RIGHT)


def path_or_robot(model: ModelLike) -> str | Robot:
    """The path where a model is one, for what is read by path; else the robot.

    Raises:
        InputError: see `robot_of`.
    """
    is_text = isinstance(model, str) and model.lstrip().startswith("<")
    return os.fspath(model) if isinstance(model, str | os.PathLike) and not is_text else robot_of(model)


def _decompiled(model: mujoco.MjModel) -> Robot:
    """A compiled model with its description: MuJoCo keeps that of the XML it loaded last.

    Raises:
        InputError: it keeps none, or that of another model.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "model.xml"
        try:
            mujoco.mj_saveLastXML(str(path), model)
            robot = Robot.from_string(path.read_text(encoding="utf-8"), "MjModel")
        except (mujoco.FatalError, OSError, InputError):
            robot = None
    if robot is None or not _alike(robot.model, model):
        what = "a compiled mujoco.MjModel has no MJCF any more, in which effects could be searched"
        raise InputError(what, where="model", right="give the path that it came from, its MjSpec, or an ee.Robot")
    return robot


def _alike(one: mujoco.MjModel, other: mujoco.MjModel) -> bool:
    """Whether two models are one, but for the digits that MJCF is written with."""
    sizes = ("nq", "nv", "nu", "nbody", "nsensordata", "names")
    if any(getattr(one, name) != getattr(other, name) for name in sizes):
        return False
    fields = ("body_mass", "body_inertia", "body_pos", "jnt_range", "dof_damping", "dof_armature", "actuator_gainprm")
    return all(np.allclose(getattr(one, name), getattr(other, name), rtol=1e-4, atol=1e-6) for name in fields)
