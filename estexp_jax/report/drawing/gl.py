"""Pictures of robots by MuJoCo's renderer with any available GL: EGL, OSMesa, or the system's own.

A child process (`gl_child.py`) renders. So settings for a GL stay there, and a crashing driver does not end the run.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

import mujoco
import numpy as np

_CHILD = Path(__file__).with_name("gl_child.py")
_TIMEOUT_S = 600.0
_INSTALL = "install libegl1 and libgl1-mesa-dri, or libosmesa6 (Debian's names), or set MUJOCO_GL to a GL that works"


class NoGlError(Exception):
    """No renderer works here; the message says what was tried and what to install."""


@final
@dataclass(frozen=True, eq=False)
class Shot:
    """A camera's view over time of one robot, or of several at one place.

    Attributes:
        qpos: (frames, robots, nq) configurations; the first robot's floor is drawn.
        rgba: (robots, ngeom, 4) colours.
        lookat: (frames, 3) target point of the camera, m.
        distance: of the camera, m.
        azimuth, elevation: of the camera, degrees.
    """

    qpos: np.ndarray
    rgba: np.ndarray
    lookat: np.ndarray
    distance: float
    azimuth: float
    elevation: float


def render_shots(
    model: mujoco.MjModel, shots: Sequence[Shot], *, width: int, height: int, shadows: bool = False
) -> np.ndarray:
    """Draw shots with equal numbers of frames and robots.

    Args:
        model: of all robots in the shots.
        shots: at least one.
        width: of a picture, pixels.
        height: of a picture, pixels.
        shadows: slow without a graphics card.

    Returns:
        (shots, frames, height, width, 3) pictures, uint8.

    Raises:
        NoGlError: no renderer works here.
    """
    job = {
        "model": _binary(model),
        "size": np.array([height, width]),
        "shadows": np.array(shadows),
        "qpos": np.stack([shot.qpos for shot in shots]),
        "rgba": np.stack([shot.rgba for shot in shots]).astype(np.float32),
        "lookat": np.stack([shot.lookat for shot in shots]),
        "camera": np.array([[shot.distance, shot.azimuth, shot.elevation] for shot in shots]),
    }
    failures = []
    for backend in backends():
        pictures = _render(job, backend)
        if isinstance(pictures, np.ndarray):
            return pictures
        failures.append(f"{backend or 'the system'}: {pictures}")
    raise NoGlError(f"robots cannot be drawn here ({'; '.join(failures) or 'MUJOCO_GL forbids it'}); {_INSTALL}")


def backends() -> tuple[str, ...]:
    """Backends to try in order: that of MUJOCO_GL, else those that this system may have."""
    requested = os.environ.get("MUJOCO_GL", "").lower()
    if requested in ("off", "disable", "disabled", "0", "false", "no"):
        return ()
    if requested:
        return (requested,)
    if not sys.platform.startswith("linux"):
        return ("",)
    return ("egl", "osmesa", "glfw") if os.environ.get("DISPLAY") else ("egl", "osmesa")


def _binary(model: mujoco.MjModel) -> np.ndarray:
    content = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, content)
    return content


def _render(job: dict[str, np.ndarray], backend: str) -> np.ndarray | str:
    """The pictures, or the reason why there are none."""
    environment = {k: v for k, v in os.environ.items() if k not in ("MUJOCO_GL", "PYOPENGL_PLATFORM")}
    if backend:
        environment["MUJOCO_GL"] = backend
    with tempfile.TemporaryDirectory() as folder:
        given, made = Path(folder) / "job.npz", Path(folder) / "pictures.npy"
        np.savez(given, allow_pickle=False, **job)
        command = [sys.executable, "-P", str(_CHILD), str(given), str(made)]
        try:
            done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            return f"took longer than {_TIMEOUT_S:.0f} s"
        if done.returncode == 0 and made.is_file():
            return np.load(made, allow_pickle=False)
    last = (done.stderr.strip().splitlines() or [f"it ended with code {done.returncode}"])[-1]
    return last[:200]
