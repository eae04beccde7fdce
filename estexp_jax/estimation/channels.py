"""Channels: the readings of recordings that are compared with those of simulations, and their ranges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import mujoco
import numpy as np

from estexp_jax.errors import InputError
from estexp_jax.physics.engines.open_loop import OpenLoopRollout
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording


@final
@dataclass(frozen=True, eq=False)
class Channels:
    """The readings that at least one recording contains.

    Attributes:
        names: as in prediction files; measured joint coordinates without a sensor are `qpos.<joint>`.
        sensors: addresses in `sensordata` of the sensor channels, which come first.
        coordinates: addresses in qpos of the encoder channels, which follow.
    """

    names: tuple[str, ...]
    sensors: np.ndarray
    coordinates: np.ndarray

    def recorded(self, recording: Recording) -> np.ndarray:
        """Readings (rows, channels) of a recording, NaN where there is no sample."""
        return np.concatenate([recording.sensor[:, self.sensors], recording.qpos[:, self.coordinates]], axis=1)

    def simulated(self, replay: OpenLoopRollout) -> np.ndarray:
        """Readings (lanes, rows, channels) of a replay."""
        return np.concatenate([replay.sensors[..., self.sensors], replay.qpos[..., self.coordinates]], axis=2)


def channels_of(robot: Robot, recordings: Sequence[Recording]) -> Channels:
    """The channels of some recordings of one robot.

    Raises:
        InputError: no recording contains any reading.
    """
    recorded = np.any([np.isfinite(r.sensor).any(axis=0) for r in recordings], axis=0)
    sensors = np.flatnonzero(recorded)
    measured = np.any([np.isfinite(r.qpos).any(axis=0) for r in recordings], axis=0)
    with_sensor = {
        int(robot.model.sensor_objid[s]) for s in _position_sensors(robot) if recorded[robot.model.sensor_adr[s]]
    }
    encoders = [j for j in robot.scalar_joints if j not in with_sensor and measured[robot.model.jnt_qposadr[j]]]
    if not (len(sensors) or encoders):
        raise InputError("the recordings hold no reading of any sensor or joint", where=recordings[0].name)
    columns, joints = robot.sensor_columns(), robot.names("joint")
    names = [columns[s] for s in sensors] + [f"qpos.{joints[j]}" for j in encoders]
    coordinates = robot.model.jnt_qposadr[encoders] if encoders else np.zeros(0, int)
    return Channels(tuple(names), sensors, coordinates)


def channel_ranges(channels: Channels, recording: Recording) -> np.ndarray:
    """Range (channels,) of each channel in a recording, by which errors are divided; NaN where it has no sample.

    For a constant channel it is the absolute value, or 1 if that is zero.
    """
    table = channels.recorded(recording)
    present = np.isfinite(table).any(axis=0)
    span = np.full(table.shape[1], np.nan)
    span[present] = np.nanmax(table[:, present], axis=0) - np.nanmin(table[:, present], axis=0)
    still = span == 0.0
    size = np.abs(np.where(np.isfinite(table), table, 0.0)).max(axis=0)
    span[still] = np.where(size[still] > 0.0, size[still], 1.0)
    return span


def _position_sensors(robot: Robot) -> np.ndarray:
    return np.flatnonzero(robot.model.sensor_type == int(mujoco.mjtSensor.mjSENS_JOINTPOS))
