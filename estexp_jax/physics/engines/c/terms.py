"""A term where it is at work in a chunk's lanes: it gathers from the step's table, and scatters back into it."""

from __future__ import annotations

from typing import final

import jax
import numpy as np

from estexp_jax.physics.effects.base import Term
from estexp_jax.physics.engines.c.acting_motors import (
    Chunk,
    WholeRobot,
    command_of,
    motor_fields,
    motor_rows,
    on_device,
)
from estexp_jax.physics.engines.c.instances import Instances, padded
from estexp_jax.physics.engines.c.law_inputs import SiteFields
from estexp_jax.physics.engines.c.laws import couples_joints, rest_program, term_program
from estexp_jax.physics.engines.c.step_table import StepTable
from estexp_jax.physics.engines.motors import Drives, drives

_ADDED = {"force": "force", "damping": "damping", "friction": "friction", "inertia": "armature"}
"""Part of the table to which each field of `JointForce` is added."""


@final
class ActingTerm:
    """A term where it is at work.

    Attributes:
        effect: the term.
        site, lane: (n,) of its instances.
        written: parts of the table that it has changed so far.
    """

    def __init__(self, e: Term, chunk: Chunk, there: Instances) -> None:
        """With its instances."""
        self.effect, self.site, self.lane, self.written = e, there.site, there.lane, set[str]()
        lane, site, dofs = padded(there.lane), padded(there.site), e.dofs(chunk.robot)
        motors = _drives(e, chunk, dofs)
        at_site = motors.motors[site].T
        self._program, self._couples = term_program(e, len(at_site)), couples_joints(e)
        self._fixed = _fixed(chunk, there, motors, lane, site)
        self._whole = WholeRobot(chunk, lane) if self._couples else None
        self._index(e, chunk, motors, dofs[site], lane, at_site)

    def _index(
        self, e: Term, chunk: Chunk, motors: Drives, dof: np.ndarray, lane: np.ndarray, at_site: np.ndarray
    ) -> None:
        """Find the places in the table that it reads and writes."""
        model, index, n = chunk.robot.model, chunk.table.index, len(self.lane)
        joint = [
            index("qpos", lane, model.jnt_qposadr[model.dof_jntid[dof]]),
            *(index(part, lane, elements) for part, elements in (("qvel", dof), ("dt", 0), ("armature", dof))),
        ]
        self._take = np.concatenate([np.array(joint), motor_rows(chunk, lane, at_site)])
        self._rows = np.empty((len(self._take) + e.n_states, len(lane)))
        self._added = {name: index(part, self.lane, dof[:n]) for name, part in _ADDED.items()}
        #: For each motor of a site: which instances have it, and where its command and its share stand.
        self._motors = [
            (moved, index("ctrl", self.lane, command_of(chunk.robot, a))[moved], index("share", self.lane, a)[moved])
            for a, moved in zip(at_site[:, :n], motors.there[self.site].T > 0.0, strict=True)
        ]

    def rest(self, table: StepTable) -> np.ndarray:
        """Hidden variables (variables, padded n) of robots that have been where the table says for long."""
        table.take(self._take, self._rows[: len(self._take)])
        return np.asarray(rest_program(self.effect)(self._fixed.p, self._rows[0], self._rows[1]))

    def act(self, table: StepTable, before: np.ndarray | None) -> np.ndarray:
        """Act in a step; hidden variables (variables, padded n) after it, of those before."""
        table.take(self._take, self._rows[: len(self._take)])
        if before is not None:
            self._rows[len(self._take) :] = before
        others = (None, None) if self._whole is None else (self._whole.fixed, self._whole.rows(table))
        does, row, n = np.asarray(self._program.act(self._fixed, self._rows, *others)), 0, len(self.lane)
        for name in self._program.names:
            if name == "command":
                for moved, command, _ in self._motors:
                    table.put(command, does[row, :n][moved])
                    row += 1
                continue
            self._apply(table, name, does[row, :n])
            row += 1
        return does[row:]

    def _apply(self, table: StepTable, name: str, x: np.ndarray) -> None:
        if name == "motor":
            self.written.add("share")
            for moved, _, share in self._motors:
                table.multiply(share, x[moved])
        else:
            self.written.add(_ADDED[name])
            table.add(self._added[name], x)


def _drives(e: Term, chunk: Chunk, dofs: np.ndarray) -> Drives:
    """The motors that count at a term's sites."""
    if e.kind != "actuator":
        return drives(chunk.robot, dofs, None)
    return drives(chunk.robot, dofs, np.array([chunk.robot.index("actuator", s) for s in e.sites(chunk.robot)]))


def _fixed(chunk: Chunk, there: Instances, motors: Drives, lane: np.ndarray, site: np.ndarray) -> SiteFields:
    """What does not change at instances."""
    joint, read = motors.joint[site], chunk.models.read
    return on_device(
        SiteFields(
            there.p,
            motor_fields(chunk.models, lane, motors.motors[site].T),
            motors.there[site].T.astype(float),
            np.asarray(read("jnt_actfrclimited")[lane, joint], bool) & motors.whole,
            np.asarray(read("jnt_actfrcrange")[lane, joint]),
            motors.limit()[site],
        )
    )
