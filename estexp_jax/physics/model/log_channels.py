"""The channels of a robot's log: what it has one number a row of, by name."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import mujoco

_SCALAR = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))


class LogChannel(NamedTuple):
    """Where a channel is in a recording."""

    table: str  #: `sensor`, `qpos` or `ctrl`
    column: int  #: in it
    element: str  #: name of its sensor, joint or actuator
    joint: int | None  #: index of the joint that it measures or drives
    quantity: tuple[str, int]  #: alike for channels that may stand in each other's place

    @property
    def measures_position(self) -> bool:
        """Whether it is the position of a hinge or slide joint."""
        return self.table == "qpos" or self.quantity == ("sensor", int(mujoco.mjtSensor.mjSENS_JOINTPOS))

    @property
    def ours(self) -> str:
        """Our column of it."""
        return f"{self.table}.{self.element}"


def log_channels(model: mujoco.MjModel, names: Mapping[str, Sequence[str]]) -> dict[str, LogChannel]:
    """Sensors of one value, positions of joints that no sensor measures, and actuators of one command, by name.

    The name is that of the element; where several have it, our column.

    Args:
        model: the robot's.
        names: of its sensors, joints and actuators.
    """
    found = [*_readings(model, names), *_commands(model, names)]
    often = Counter(channel.element for channel in found)
    return {c.element if often[c.element] == 1 else c.ours: c for c in found}


def _readings(model: mujoco.MjModel, names: Mapping[str, Sequence[str]]) -> list[LogChannel]:
    found, measured = [], set[int]()
    for sensor, name in enumerate(names["sensor"]):
        kind, place = int(model.sensor_type[sensor]), int(model.sensor_objid[sensor])
        of_joint = int(model.sensor_objtype[sensor]) == int(mujoco.mjtObj.mjOBJ_JOINT)
        if kind == int(mujoco.mjtSensor.mjSENS_JOINTPOS):
            measured.add(place)
        if model.sensor_dim[sensor] == 1:
            joint = place if of_joint else None
            found.append(LogChannel("sensor", int(model.sensor_adr[sensor]), name, joint, ("sensor", kind)))
    for joint, name in enumerate(names["joint"]):
        kind = int(model.jnt_type[joint])
        if joint not in measured and kind in _SCALAR:
            found.append(LogChannel("qpos", int(model.jnt_qposadr[joint]), name, joint, ("qpos", kind)))
    return found


def _commands(model: mujoco.MjModel, names: Mapping[str, Sequence[str]]) -> list[LogChannel]:
    found = []
    for actuator, name in enumerate(names["actuator"]):
        if model.actuator_ctrlnum[actuator] == 1:
            direct = model.actuator_trntype[actuator] == mujoco.mjtTrn.mjTRN_JOINT
            joint = int(model.actuator_trnid[actuator, 0]) if direct else None
            found.append(LogChannel("ctrl", int(model.actuator_ctrladr[actuator]), name, joint, ("ctrl", 0)))
    return found
