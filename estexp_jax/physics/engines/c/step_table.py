"""Numbers of a chunk's lanes in one step, side by side in a table, so that laws gather and scatter by flat indices."""

from __future__ import annotations

from typing import final

import mujoco
import numpy as np

PARTS = ("qpos", "qvel", "dt", "ctrl", "on", "share", "rotor_inertia", "force", "damping", "friction", "gravity")


@final
class StepTable:
    """A table (lanes, columns) of positions and speeds, motors, and what acts on the degrees of freedom.

    Attributes:
        table: (lanes, columns).
    """

    def __init__(self, model: mujoco.MjModel, lanes: int) -> None:
        """For lanes of a model; all zeros."""
        motors = model.nactuator
        sizes = {"qpos": model.nq, "dt": 1, "ctrl": model.nu, "on": motors, "share": motors}
        self._columns, end = {}, 0
        for part in PARTS:
            size = sizes.get(part, model.nv)
            self._columns[part] = slice(end, end + size)
            end += size
        self.table = np.zeros((lanes, end))
        self._flat = self.table.reshape(-1)

    def __getitem__(self, part: str) -> np.ndarray:
        """A part of the table, (lanes, its columns)."""
        return self.table[:, self._columns[part]]

    def index(self, part: str, lanes: np.ndarray, elements: np.ndarray | int) -> np.ndarray:
        """Flat indices of elements of a part, of lanes."""
        return lanes * self.table.shape[1] + self._columns[part].start + elements

    def take(self, index: np.ndarray, out: np.ndarray) -> None:
        """Gather numbers by flat indices."""
        np.take(self._flat, index, out=out, mode="clip")

    def put(self, index: np.ndarray, x: np.ndarray) -> None:
        """Write numbers."""
        self._flat[index] = x

    def add(self, index: np.ndarray, x: np.ndarray) -> None:
        """Add numbers; indices may repeat."""
        np.add.at(self._flat, index, x)

    def multiply(self, index: np.ndarray, x: np.ndarray) -> None:
        """Multiply by numbers; indices may repeat."""
        np.multiply.at(self._flat, index, x)
