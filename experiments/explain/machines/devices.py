"""The devices of the real recordings: what their columns mean, which recordings teach and which test.

Units and meanings are those the data's own README states. A log is cut where only a piece is wanted.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

Columns = dict[str, np.ndarray]
"""A log: columns by their published names."""

_XL330_STIFFNESS = 0.2217
"""N m/rad at P gain 100 and 7.4 V: firmware duty = P error 4096 / (2 pi 256 885), times stall torque."""


@dataclass(frozen=True)
class Device:
    """A device and its recordings.

    Attributes:
        name: of its folder.
        time: its column, and the factor that makes it seconds.
        columns: ours to theirs.
        splits: by name, the files that test; all others teach.
        piece: seconds of each recording in a quick run.
        most: most training recordings in a quick run.
        published: what its authors or others found, as sentences.
    """

    name: str
    time: tuple[str, float]
    columns: Mapping[str, str]
    splits: Mapping[str, Sequence[str]]
    piece: float
    most: int
    published: Sequence[str] = ()
    skipped: Sequence[str] = field(default=())

    def files(self, data: Path) -> list[str]:
        """Names of all its recordings."""
        return sorted(p.name for p in (data / self.name).glob("*.csv") if p.name not in self.skipped)


_MOTIONS = ("lift_and_drop", "sin_sin", "sin_time_square", "up_and_down")
_SO101 = ("Rotation", "Pitch", "Elbow", "Wrist_Pitch", "Wrist_Roll", "Jaw")
DEVICES = {
    d.name: d
    for d in (
        Device(
            "xl330",
            ("timestamp", 1.0),
            {"ctrl.servo": "goal_position", "sensor.angle": "position", "enable.servo": "torque_enable"},
            {f"kp{gain}": tuple(f"kp{gain}_{m}.csv" for m in _MOTIONS) for gain in (800, 200, 100)},
            piece=3.0,
            most=4,
            published=("Coulomb, viscous, Stribeck and load-dependent friction (Duclusaud et al., ICRA 2025).",),
        ),
        Device(
            "double_pendulum",
            ("time", 1.0),
            {
                "ctrl.shoulder": "tau_meas1",
                "ctrl.elbow": "tau_meas2",
                "sensor.q1": "pos_meas1",
                "sensor.q2": "pos_meas2",
                "sensor.qd1": "vel_meas1",
                "sensor.qd2": "vel_meas2",
            },
            {"swing_up": ("154220.csv",)},
            piece=4.0,
            most=3,
            published=(
                "Coulomb-like friction cf atan(100 v) at both joints, cf = 0.16 and 0.12 N m (the authors' model).",
                "Rotor inertia of 36 * 6.29e-5 = 0.00226 kg m2 at each joint.",
            ),
        ),
        Device(
            "so101",
            ("timestamp_us", 1e-6),
            {f"ctrl.{j}": f"command_{j}" for j in _SO101} | {f"sensor.{j}_pos": f"position_{j}" for j in _SO101},
            {"held_out": ("friction_gravity.csv", "prbs_excitation.csv")},
            piece=12.0,
            most=2,
            published=("Pitch and Elbow sag by 0.03 to 0.08 rad under gravity; the lag is not a pure delay.",),
        ),
    )
}
"""All devices by name."""


def read(path: Path) -> Columns:
    """A published log."""
    with path.open(encoding="utf-8") as file:
        names = file.readline().strip().split(",")
        return dict(zip(names, np.loadtxt(file, delimiter=",", ndmin=2).T, strict=True))


def settings(device: Device, file: str, log: Columns) -> dict[str, float]:
    """What is known to differ in a recording: the XL330's stiffness follows its P gain and its supply."""
    if device.name != "xl330":
        return {}
    gain, volts = float(file.split("_")[0].removeprefix("kp")), float(np.mean(log["input_volts"]))
    return {"actuator.servo.kp": _XL330_STIFFNESS * gain / 100.0 * volts / 7.4}


def cut(device: Device, log: Columns, seconds: float | None) -> Columns:
    """The first seconds of a log."""
    if seconds is None:
        return log
    time = log[device.time[0]] * device.time[1]
    return {name: column[time - time[0] <= seconds] for name, column in log.items()}
