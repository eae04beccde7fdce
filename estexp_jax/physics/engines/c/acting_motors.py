"""Motors of lanes at the instances of an effect: their numbers, and where they stand in the step's table."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from estexp_jax.physics.effects.sites import driven_actuators
from estexp_jax.physics.engines.c.carried_momenta import CarriedMomenta
from estexp_jax.physics.engines.c.lane_models import LaneModels
from estexp_jax.physics.engines.c.law_inputs import MotorFields, RobotFields
from estexp_jax.physics.engines.c.step_table import StepTable
from estexp_jax.physics.model.actuators import first_input
from estexp_jax.physics.model.robot import Robot


class Chunk(NamedTuple):
    """What the effects of one chunk's lanes share."""

    robot: Robot
    models: LaneModels
    table: StepTable
    carried: CarriedMomenta | None


def motor_fields(models: LaneModels, lane: np.ndarray, motors: np.ndarray) -> MotorFields:
    """Numbers of motors (motors, n) of lanes (n,)."""
    model = models.batch.model
    inputs, outputs = first_input(model)[motors], model.actuator_outadr[motors]
    address = dict.fromkeys(("actuator_ctrllimited", "actuator_ctrlrange"), inputs) | {"actuator_gear": outputs}
    fields = (_limits(name, models.read(name)[lane, address.get(name, motors)]) for name in MotorFields._fields)
    return MotorFields(*fields)


def _limits(name: str, x: np.ndarray) -> np.ndarray:
    return x.astype(bool) if name.endswith("limited") else x


def motor_rows(chunk: Chunk, lane: np.ndarray, motors: np.ndarray) -> np.ndarray:
    """Indices (3 motors, n) in the table of the motors' commands, switches and shares."""
    parts = ("ctrl", command_of(chunk.robot, motors)), ("on", motors), ("share", motors)
    return np.concatenate([chunk.table.index(part, lane, elements) for part, elements in parts])


def command_of(robot: Robot, motors: np.ndarray) -> np.ndarray:
    """Address of the first command of motors; motors without one get any."""
    return first_input(robot.model)[motors]


class WholeRobot:
    """Joints and motors of the whole robots that instances are on.

    Attributes:
        fixed: what does not change.
        size: numbers of joints and motors.
    """

    def __init__(self, chunk: Chunk, lane: np.ndarray) -> None:
        """For instances on lanes (n,)."""
        robot, table, model = chunk.robot, chunk.table, chunk.robot.model
        joints, motors = np.array(robot.scalar_joints, dtype=int), np.array(driven_actuators(robot), dtype=int)
        driven = np.array([robot.joint_of_actuator(int(a)) for a in motors], dtype=int)
        self.size, read = (len(joints), len(motors)), chunk.models.read
        self.fixed = RobotFields(
            joints + 1.0,
            motor_fields(chunk.models, lane, motors[:, None]),
            (joints[:, None] == driven).astype(float),
            read("jnt_actfrclimited")[lane, joints[:, None]].astype(bool),
            read("jnt_actfrcrange")[lane, joints[:, None]],
        )
        self._take = np.concatenate(
            [
                table.index("qpos", lane, model.jnt_qposadr[joints][:, None]),
                table.index("qvel", lane, model.jnt_dofadr[joints][:, None]),
                motor_rows(chunk, lane, motors[:, None]),
            ]
        )
        self._rows = np.empty(self._take.shape)

    def rows(self, table: StepTable) -> np.ndarray:
        """What changes, as `RobotInputs` takes it."""
        table.take(self._take, self._rows)
        return self._rows
