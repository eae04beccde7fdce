"""A command law where it is at work in a chunk's lanes."""

from __future__ import annotations

from typing import final

import numpy as np

from estexp_jax.physics.effects.base import CommandLaw
from estexp_jax.physics.engines.c.acting_motors import Chunk, command_of, motor_fields
from estexp_jax.physics.engines.c.instances import Instances
from estexp_jax.physics.engines.c.laws import command_program, rest_program
from estexp_jax.physics.engines.c.step_table import StepTable
from estexp_jax.physics.engines.c.terms import stacked_rows


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
        robot, index, lane = chunk.robot, chunk.table.index, there.lane
        motor = e.actuators(robot)[there.site]
        joint = np.array([robot.joint_of_actuator(int(a)) for a in motor], float)
        driven = np.isin(joint, robot.scalar_joints)
        joint = np.where(driven, joint, 0).astype(int)
        fields = motor_fields(chunk.models, lane, motor[None])
        self._resting, self._law = (there.p, fields), command_program(e).bound((there.p, fields, driven), len(lane))
        model = robot.model
        self._command = index("ctrl", lane, command_of(robot, motor))
        self._take = np.array(
            [
                index("qpos", lane, model.jnt_qposadr[joint]),
                index("qvel", lane, model.jnt_dofadr[joint]),
                self._command,
                index("dt", lane, 0),
            ]
        )
        self._rows = np.empty((4 + e.n_states, len(lane)))

    def rest(self, table: StepTable) -> np.ndarray:
        """Hidden variables (variables, n) of robots whose commands, in the table, have been in force for long."""
        table.take(self._take, self._rows[:4])
        n = len(self.lane)
        return stacked_rows(rest_program(self.effect).bound(self._resting, n)(self._rows[2]), n)

    def act(self, table: StepTable, before: np.ndarray | None) -> np.ndarray:
        """Act in a step; hidden variables (variables, n) after it, of those before."""
        table.take(self._take, self._rows[:4])
        if before is not None:
            self._rows[4:] = before
        command, *state = self._law(self._rows)
        table.put(self._command, command)
        return stacked_rows(state, len(self.lane))
