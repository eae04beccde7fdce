"""The numbers of a robot's model as lanes take them: known ones as Python numbers, edited ones as arrays of robots."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

import jax
import jax.numpy as jnp
import mujoco
import numpy as np

from estexp_jax.lanes.algebra import Matrix, Scalar, Vector, from_quaternion

_ROUNDING = 1e-15


@final
@dataclass(frozen=True, eq=False)
class ModelParameters:
    """Fields of a model, nominal where no edit writes them.

    Attributes:
        model: the nominal model.
        varying: field name to its values in N robots, robots last: `body_mass` (nbody, N), `opt.gravity` (3, N).
        dtype: of arrays.
    """

    model: mujoco.MjModel
    varying: Mapping[str, jax.Array]
    dtype: Any

    def get(self, field: str, members: Sequence[int], column: int | tuple[int, ...] | None = None) -> Scalar:
        """A number of k alike elements.

        Args:
            field: MuJoCo's name.
            members: (k,) index of each element on the field's first axis.
            column: index on the further axes, if there are any.
        """
        tail = () if column is None else (column if isinstance(column, tuple) else (column,))
        rows = np.asarray(members, dtype=int)
        if field in self.varying:
            values = self.varying[field][(slice(None), *tail)]
            return values[rows[0]] if len(rows) == 1 else jnp.stack([values[r] for r in rows])
        return self.known(getattr(self.model, field)[(rows, *tail)])

    def known(self, values: np.ndarray) -> Scalar:
        """Numbers (k,) that all robots share: one Python number if they are alike, else an array (k, 1)."""
        values = np.asarray(values, dtype=float)
        if np.all(values == values[0]):
            first = float(values[0])
            return int(first) if first in (0.0, 1.0, -1.0) else first
        return jnp.asarray(values.astype(self.dtype)[:, None])

    def vector(self, field: str, members: Sequence[int]) -> Vector:
        """Three numbers."""
        return tuple(self.get(field, members, i) for i in range(3))

    def rotation(self, field: str, members: Sequence[int]) -> Matrix:
        """Rotation matrix of a quaternion field."""
        if field in self.varying:
            return from_quaternion(*(self.get(field, members, i) for i in range(4)))
        return self.known_rotation(getattr(self.model, field)[np.asarray(members, dtype=int)])

    def known_rotation(self, quaternions: np.ndarray) -> Matrix:
        """Rotation matrix of quaternions (k, 4) that all robots share."""
        matrices = np.array([rotation_matrix(q) for q in quaternions])
        return tuple(tuple(self.known(matrices[:, i, j]) for j in range(3)) for i in range(3))

    def known_vector(self, vectors: np.ndarray) -> Vector:
        """Vectors (k, 3) that all robots share."""
        return tuple(self.known(vectors[:, i]) for i in range(3))

    def gravity(self) -> Vector:
        """Acceleration of gravity, world axes."""
        if self.model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_GRAVITY:
            return (0, 0, 0)
        if "opt.gravity" in self.varying:
            return tuple(self.varying["opt.gravity"][i] for i in range(3))
        return self.known_vector(np.asarray(self.model.opt.gravity)[None])


def rotation_matrix(quaternion: np.ndarray) -> np.ndarray:
    """Matrix (3, 3) of a quaternion (4,), with exact zeros and ones where only rounding hides them."""
    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, np.asarray(quaternion, dtype=float))
    nearest = np.round(matrix)
    return np.where(np.abs(matrix - nearest) < _ROUNDING, nearest, matrix).reshape(3, 3)


def world_pose(
    model: mujoco.MjModel, body: int, position: np.ndarray, quaternion: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Pose in the world of what has this pose (3,), (4,) on a body that cannot move."""
    while body:
        turned, whole = np.zeros(3), np.zeros(4)
        mujoco.mju_rotVecQuat(turned, position, model.body_quat[body])
        mujoco.mju_mulQuat(whole, model.body_quat[body], quaternion)
        position, quaternion = model.body_pos[body] + turned, whole
        body = int(model.body_parentid[body])
    return position, quaternion
