"""Torques that gravity puts on the hinges and slides of lanes."""

from __future__ import annotations

from typing import final

import mujoco
import numpy as np

from estexp_jax.physics.engines.c.lane_models import LaneModels


@final
class GravityTorques:
    """The torque of gravity on each degree of freedom: its axis' part of the weight of all that its joint carries."""

    def __init__(self, models: LaneModels) -> None:
        """With edited models."""
        model = models.batch.model
        self._joint = model.dof_jntid
        self._body = model.jnt_bodyid[self._joint]
        self._slides = model.jnt_type[self._joint] == int(mujoco.mjtJoint.mjJNT_SLIDE)
        self._weight = models.read("body_subtreemass")[:, self._body, None] * models.read("opt.gravity")[:, None]
        self._centre, self._anchor, self._axis = (models.batch.bind(n) for n in ("subtree_com", "xanchor", "xaxis"))

    def torques(self) -> np.ndarray:
        """Of all lanes (lanes, nv), N m or N, where positions have been computed; nothing of ball and free joints."""
        arm = self._centre[:, self._body] - self._anchor[:, self._joint]
        moment = np.where(self._slides[:, None], self._weight, np.cross(arm, self._weight))
        return np.einsum("lij,lij->li", self._axis[:, self._joint], moment)
