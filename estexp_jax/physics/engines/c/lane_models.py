"""Models of a chunk's lanes: one MuJoCo batch, with the fields that differ from lane to lane."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from functools import lru_cache
from typing import Any, final

import mujoco
import numpy as np

from estexp_jax.errors import InputError
from estexp_jax.physics.effects.base import NEVER
from estexp_jax.physics.effects.sites import driven_actuators
from estexp_jax.physics.engines.c.batches import lane_fields, new_batch, refusals
from estexp_jax.physics.engines.c.histories import lengthen_histories
from estexp_jax.physics.model.robot import Robot

_KEPT_PER_SIMULATION = int(mujoco.mjtEnableBit.mjENBL_SLEEP) | int(getattr(mujoco.mjtEnableBit, "mjENBL_IPC", 0))
"""Flags with which MuJoCo's batch needs an `MjData` for each simulation."""


_OF_SIMPLE = ("body_simple", "dof_simplenum", "dof_M0")
"""Fields that depend on which bodies are simple."""


def c_field_of(model: mujoco.MjModel, name: str) -> Any:
    """A field of a model, or with `opt.` before it of its options."""
    return getattr(model.opt, name.removeprefix("opt.")) if name.startswith("opt.") else getattr(model, name, None)


def recorded_fields(robot: Robot, per_recording: Sequence[Robot]) -> dict[str, np.ndarray]:
    """Fields (recordings, ...) of the models in which known settings of recordings make a difference.

    Args:
        robot: the robot without settings.
        per_recording: the robot with the settings of each recording.

    Raises:
        InputError: the settings change the model's structure.
    """
    distinct = {id(r): r.model for r in per_recording if r is not robot}
    found: dict[str, np.ndarray] = {}
    for name in lane_fields() if distinct else ():
        own = np.asarray(c_field_of(robot.model, name))
        others = {key: np.asarray(c_field_of(model, name)) for key, model in distinct.items()}
        if own.dtype.kind not in "fiub" or name.startswith("name"):
            continue
        if any(x.shape != own.shape for x in others.values()):
            raise InputError("a recording's settings change what the model consists of", where=robot.source)
        if any(not np.array_equal(x, own, equal_nan=own.dtype.kind == "f") for x in others.values()):
            found[name] = np.stack([others.get(id(r), own) for r in per_recording])
    return found


@lru_cache(maxsize=16)
def _lane_model(robot: Robot, *, simple: bool, finer: bool) -> mujoco.MjModel:
    """The model that lanes begin with; bodies may be simple, or none is; with buffers for finer steps, or as it is."""
    finer = finer and robot.model.nhistory > 0
    if simple and not finer:
        return robot.model
    spec = robot.spec.copy()
    if finer:
        lengthen_histories(spec)
    for body in spec.bodies if not simple else ():
        body.simple = 0
    return spec.compile()


ARMED = ("jnt_limited", "jnt_range"), ("actuator_forcelimited", "actuator_forcerange")
"""Switches and limits that `LaneModels.arm` may give a model without effect."""


@final
class LaneModels:
    """The models of some lanes.

    Attributes:
        batch: MuJoCo's, on one thread: chunks run beside each other.
        lanes: how many.
        failed: (lanes,) those whose edited models MuJoCo refuses.
    """

    def __init__(
        self,
        robot: Robot,
        recorded: dict[str, np.ndarray],
        recording: Sequence[int],
        *,
        simple: bool = True,
        finer: bool = False,
    ) -> None:
        """Nominal models with their recordings' settings.

        Args:
            robot: the nominal robot.
            recorded: its `recorded_fields`.
            recording: index of each lane's recording.
            simple: whether bodies may be *simple* as MuJoCo compiles them: those have to keep their centres of mass.
            finer: whether steps may be shorter than the robot's own, for which delays need longer buffers.
        """
        model = copy.copy(_lane_model(robot, simple=simple, finer=finer))
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET  # a lane that blows up must not start again
        persistent = bool(int(model.opt.enableflags) & _KEPT_PER_SIMULATION)
        self._robot, self.lanes, self.failed = robot, len(recording), np.zeros(len(recording), bool)
        self.batch = new_batch(model, self.lanes, persistent=persistent)
        for name, values in recorded.items():
            if not simple and name in _OF_SIMPLE:
                continue
            own, each = self.batch.expand(name), values[list(recording)]
            own[...] = each[:, : own.shape[1]] if own.ndim > 1 else each  # of `bvh_aabb`, the bodies' part alone
        if "opt.disableflags" in recorded:
            self.batch.expand("opt.disableflags")[...] |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)

    def own(self, name: str) -> np.ndarray:
        """A field (lanes, ...) that may be written."""
        return self.batch.expand(name)

    def read(self, name: str) -> np.ndarray:
        """A field (lanes, ...), not to be written."""
        own = self.batch.expanded(name)
        if own is not None:
            return own
        nominal = np.asarray(c_field_of(self.batch.model, name))
        return np.broadcast_to(nominal, (self.lanes, *nominal.shape))

    def derive(self, lanes: np.ndarray) -> bool:
        """Derive lanes' constants anew; whether MuJoCo could, for all of them."""
        try:
            self.batch.set_const(lanes)
        except refusals() as error:
            self.failed[error.ids] = True
        return not self.failed.any()

    def arm(self, parts: set[str], lanes: np.ndarray) -> None:
        """Give lanes limits without effect where the model has none, as far as effects' `arms` name them."""
        if "jnt_range" in parts:
            self._arm("jnt_limited", "jnt_range", lanes, self._robot.scalar_joints)
        if "actuator_forcerange" in parts:
            self._arm("actuator_forcelimited", "actuator_forcerange", lanes, driven_actuators(self._robot))

    def _arm(self, switch: str, limits: str, lanes: np.ndarray, elements: Sequence[int]) -> None:
        limited, ranges = self.own(switch), self.own(limits)
        for element in elements:
            free = lanes[limited[lanes, element] == 0]
            limited[free, element], ranges[free, element] = 1, (-NEVER, NEVER)
