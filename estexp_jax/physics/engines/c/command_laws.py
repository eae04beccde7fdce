"""A command law where it is at work in a chunk's lanes."""

from __future__ import annotations

from typing import final

import numpy as np

from estexp_jax.physics.effects.base import CommandLaw
from estexp_jax.physics.engines.c.acting_motors import Chunk, command_of, motor_fields, on_device
from estexp_jax.physics.engines.c.instances import Instances, padded
from estexp_jax.physics.engines.c.laws import command_program, rest_program
from estexp_jax.physics.engines.c.step_table import StepTable


@final
class ActingCommandLaw:
    """A command law where it is at work.

    Attributes:
        effect: the law.
        site, lane: (n,) of its instances.
    """

    def __init__(self, e: CommandLaw, chunk: Chunk, there: Instances) -> None:
        """With its instances."""
        self.effect, self.site, self.lane = e, there.site, there.lane
        robot, index, lane = chunk.robot, chunk.table.index, padded(there.lane)
        motor = e.actuators(robot)[padded(there.site)]
        joint = np.array([robot.joint_of_actuator(int(a)) for a in motor], float)
        driven = np.isin(joint, robot.scalar_joints)
        joint = np.where(driven, joint, 0).astype(int)
        self._fixed = on_device((there.p, motor_fields(chunk.models, lane, motor[None]), driven))
        model = robot.model
        command = index("ctrl", lane, command_of(robot, motor))
        self._take = np.array(
            [
                index("qpos", lane, model.jnt_qposadr[joint]),
                index("qvel", lane, model.jnt_dofadr[joint]),
                command,
                index("dt", lane, 0),
            ]
        )
        self._rows = np.empty((4 + e.n_states, len(lane)))
        self._command = command[: len(self.lane)]
        self._program = command_program(e)

    def rest(self, table: StepTable) -> np.ndarray:
        """Hidden variables (variables, padded n) of robots whose commands, in the table, have been in force for long."""
        table.take(self._take, self._rows[:4])
        p, motor, _ = self._fixed
        return np.asarray(rest_program(self.effect)(p, motor, self._rows[2]))

    def act(self, table: StepTable, before: np.ndarray | None) -> np.ndarray:
        """Act in a step; hidden variables (variables, padded n) after it, of those before."""
        table.take(self._take, self._rows[:4])
        if before is not None:
            self._rows[4:] = before
        does = np.asarray(self._program(*self._fixed, self._rows))
        table.put(self._command, does[0, : len(self.lane)])
        return does[1:]
