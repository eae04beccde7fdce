"""Differences that the known settings of recordings make in a robot's MJX model."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import jax
import numpy as np

from estexp_jax.errors import InputError
from estexp_jax.physics.engines.mjx.model import MjxModel, fields_of, mjx_model
from estexp_jax.physics.model.robot import Robot


class PerRecordingModel(NamedTuple):
    """Leaves of the nominal MJX model that differ between recordings.

    Attributes:
        positions: among the leaves of the MJX model.
        values: for each of them, (recordings, ...).
        fields: names of those that are fields of numbers.
    """

    positions: tuple[int, ...]
    values: tuple[np.ndarray, ...]
    fields: frozenset[str]


def per_recording_model(nominal: MjxModel, per_recording: Sequence[Robot]) -> PerRecordingModel:
    """The leaves that known settings of recordings change.

    Args:
        nominal: the robot without settings.
        per_recording: the robot with the settings of each recording.

    Raises:
        InputError: the settings change the model's structure.
    """
    leaves, tree = jax.tree.flatten(nominal.model)
    distinct = {id(r): r for r in per_recording}
    variants = {k: jax.tree.flatten(mjx_model(r, nominal.catalogue).model) for k, r in distinct.items()}
    if any(other != tree for _, other in variants.values()):
        raise InputError("a recording's settings change what the model consists of", where=nominal.robot.source)
    each = [variants[id(r)][0] for r in per_recording]
    positions = tuple(i for i, leaf in enumerate(leaves) if any(not np.array_equal(leaf, own[i]) for own in each))
    names = {id(leaf): name for name, leaf in fields_of(nominal.model).items()}
    fields = frozenset(names[id(leaves[i])] for i in positions if id(leaves[i]) in names)
    return PerRecordingModel(
        positions, tuple(np.stack([np.asarray(own[i]) for own in each]) for i in positions), fields
    )
