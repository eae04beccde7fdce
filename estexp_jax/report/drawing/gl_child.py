"""Draws robots in a separate process: graphics drivers may crash, and MuJoCo chooses one on import.

`gl.py` starts it with MUJOCO_GL set, as a script that imports nothing of the package.
"""

from __future__ import annotations

import os
import sys
import threading
import time
from typing import Any

import mujoco
import numpy as np

_THICKER = 0.03
_FINEST = {"numslices": 64, "numstacks": 64, "numquads": 16}
"""Parts that round shapes and planes are drawn of, whatever the model asks for."""
_POLL_S = 1.0
"""Period at which it checks that its parent is alive, s."""


def draw_shot(job: Any) -> np.ndarray:
    """Pictures (shots, frames, height, width, 3) of a job as `gl.py` writes it."""
    model = _load_model(job["model"])
    height, width = (int(x) for x in job["size"])
    shots, frames = job["qpos"].shape[:2]
    model.vis.quality.offsamples = 0  # multisampling is slow without a graphics card
    model.vis.quality.shadowsize = 1024
    for name, most in _FINEST.items():
        setattr(model.vis.quality, name, min(getattr(model.vis.quality, name), most))
    model.vis.global_.offwidth, model.vis.global_.offheight = width, height
    pictures = np.zeros((shots, frames, height, width, 3), np.uint8)
    with mujoco.Renderer(model, height, width) as renderer:
        renderer.scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = 0
        renderer.scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = int(job["shadows"])
        data, ghost = mujoco.MjData(model), mujoco.MjData(model)
        for shot in range(shots):
            for frame in range(frames):
                _compose(renderer, data, ghost, job, shot, frame)
                pictures[shot, frame] = renderer.render()
    return pictures


def _load_model(content: np.ndarray) -> mujoco.MjModel:
    return mujoco.MjModel.from_binary_path("model.mjb", {"model.mjb": content.tobytes()})


def _compose(renderer: Any, data: Any, ghost: Any, job: Any, shot: int, frame: int) -> None:
    """One scene: the robot in its first configuration, and copies in the others, each in its colours."""
    model = renderer.model
    camera = mujoco.MjvCamera()
    camera.lookat[:] = job["lookat"][shot, frame]
    camera.distance, camera.azimuth, camera.elevation = job["camera"][shot]
    for layer, qpos in enumerate(job["qpos"][shot, frame]):
        model.geom_rgba[:] = job["rgba"][shot, layer]
        now = data if layer == 0 else ghost
        now.qpos[:] = qpos
        mujoco.mj_kinematics(model, now)
        mujoco.mj_camlight(model, now)
        if layer == 0:
            renderer.update_scene(now, camera)
            for lamp in renderer.scene.lights[: renderer.scene.nlight]:  # lights follow a moving robot
                if not lamp.headlight:
                    lamp.pos[:2] += (job["lookat"][shot, frame] - job["lookat"][shot, 0])[:2]
        else:
            moving, first = mujoco.mjtCatBit.mjCAT_DYNAMIC, renderer.scene.ngeom
            mujoco.mjv_addGeoms(model, now, mujoco.MjvOption(), mujoco.MjvPerturb(), moving, renderer.scene)
            for geom in renderer.scene.geoms[first : renderer.scene.ngeom]:
                geom.size[:] *= 1.0 + _THICKER * layer  # avoids flicker of coinciding geoms


def _end_with_parent(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(_POLL_S)
    os._exit(1)


if __name__ == "__main__":
    threading.Thread(target=_end_with_parent, args=(os.getppid(),), daemon=True).start()
    with np.load(sys.argv[1], allow_pickle=False) as given:
        np.save(sys.argv[2], draw_shot(given), allow_pickle=False)
