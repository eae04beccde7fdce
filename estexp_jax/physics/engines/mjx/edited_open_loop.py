"""What open loops on MJX and in lanes share: models edited with MJX's arrays, each with its recording's settings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import jax
import numpy as np
from mujoco import mjx

from estexp_jax.physics.effects.changes import Values
from estexp_jax.physics.engines.mjx.capabilities import reduced_to_mjx
from estexp_jax.physics.engines.mjx.model import MjxModel
from estexp_jax.physics.engines.open_loop import OpenLoopSimulator
from estexp_jax.physics.engines.per_recording_model import PerRecordingModel


@dataclass(frozen=True, eq=False)
class EditedOpenLoop(OpenLoopSimulator):
    """Open loops whose lanes have MJX's models.

    Attributes:
        on_mjx: the nominal robot and the catalogue of effects, for MJX.
        differing: what differs from recording to recording.
    """

    on_mjx: MjxModel
    differing: PerRecordingModel

    @property
    def left_out(self) -> tuple[str, ...]:
        """See `OpenLoopSimulator`."""
        return reduced_to_mjx(self.robot).left_out

    def model(self, values: Values, overrides: tuple) -> mjx.Model:
        """One lane's model: with its recording's settings, and its edits."""
        leaves, tree = jax.tree.flatten(self.on_mjx.model)
        for position, leaf in zip(self.differing.positions, overrides, strict=True):
            leaves[position] = leaf
        return self.on_mjx.edited(jax.tree.unflatten(tree, leaves), values)

    def overrides(self, recording: Sequence[int]) -> tuple[np.ndarray, ...]:
        """Leaves of the model (lanes, ...) in which recordings differ, from the index of each lane's."""
        return tuple(values[list(recording)] for values in self.differing.values)
