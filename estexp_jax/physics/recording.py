"""A robot's log aligned with its model: one row a time stamp, one column an element."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import final

import numpy as np

HEALTHY = "healthy"
"""The role of recordings of the same robot when it was well."""
ROLES = ("train", "test", HEALTHY)
"""What a recording serves for: it is fitted, kept for the test, or of the robot when it was well."""


@final
@dataclass(frozen=True, eq=False)
class Recording:
    """One recording of one robot. Absent samples are NaN; commands and motor switches have no gaps.

    Attributes:
        name: file name it came from, with extension.
        time: (rows,) in s, strictly increasing.
        ctrl: (rows, nu) the command in force from each row on, in the actuator's control unit.
        enable: (rows, nactuator) 1.0 where the motor is on from this row on, else 0.0.
        sensor: (rows, nsensordata) readings, taken before the row's command acts.
        qpos: (rows, nq) measured configuration; NaN where nothing measured it.
        qvel: (rows, nv) measured velocity; NaN where nothing measured it.
        role: `train`, `test`, or `healthy`: of the robot when it was well.
        settings: what is known to differ in this recording, `<element>.<name>.<attribute>` to value.
        notes: remarks of the reader on what it found (ignored columns, gaps).
        clock_faults: that its clocks do not agree, as sentences: alone it can look like any physics.
        guessed: (rows,) which rows' commands nobody logged; None: all were logged.
    """

    name: str
    time: np.ndarray
    ctrl: np.ndarray
    enable: np.ndarray
    sensor: np.ndarray
    qpos: np.ndarray
    qvel: np.ndarray
    role: str = "train"
    settings: Mapping[str, float | tuple[float, ...]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    clock_faults: tuple[str, ...] = ()
    guessed: np.ndarray | None = None

    def __post_init__(self) -> None:
        rows = self.time.shape[0]
        if rows < 2 or np.any(np.diff(self.time) <= 0.0) or not np.all(np.isfinite(self.time)):
            raise ValueError(f"{self.name}: time must be finite, strictly increasing and at least two rows long")
        for name in ("ctrl", "enable", "sensor", "qpos", "qvel"):
            table = getattr(self, name)
            if table.ndim != 2 or table.shape[0] != rows:
                raise ValueError(f"{self.name}: {name} is {table.shape}, not ({rows}, columns)")
        if not (np.all(np.isfinite(self.ctrl)) and np.all(np.isfinite(self.enable))):
            raise ValueError(f"{self.name}: commands and motor switches may have no gaps")
        if self.role not in ROLES:
            raise ValueError(f"{self.name}: role is '{self.role}', not one of {', '.join(ROLES)}")

    @property
    def rows(self) -> int:
        """Number of rows."""
        return self.time.shape[0]

    @property
    def duration(self) -> float:
        """Time from the first to the last row, s."""
        return float(self.time[-1] - self.time[0])

    @property
    def rate(self) -> float:
        """Median row rate, Hz."""
        return float(1.0 / np.median(np.diff(self.time)))
