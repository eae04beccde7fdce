"""A term where it is at work in a chunk's lanes: it gathers from the step's table, and scatters back into it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, final

import numpy as np

from estexp_jax.physics.effects.base import Term
from estexp_jax.physics.engines.c.acting_motors import (
    Chunk,
    WholeRobot,
    command_of,
    motor_fields,
    motor_rows,
)
from estexp_jax.physics.engines.c.carried_momenta import carried_dofs
from estexp_jax.physics.engines.c.instances import Instances
from estexp_jax.physics.engines.c.law_inputs import OWN_ROWS, SiteFields
from estexp_jax.physics.engines.c.laws import couples_joints, mount_rows, rest_program, term_program
from estexp_jax.physics.engines.c.step_table import StepTable
from estexp_jax.physics.engines.motors import Drives, drives

_ADDED = {"force": "force", "damping": "damping", "friction": "friction", "inertia": "rotor_inertia"}
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
        dofs = e.dofs(chunk.robot)
        motors = _drives(e, chunk, dofs)
        self._whole = WholeRobot(chunk, self.lane) if couples_joints(e) else None
        law, self._names = term_program(e, motors.motors.shape[1], self._whole.size if self._whole else None)
        fixed = _fixed(chunk, there, motors), self._whole.fixed if self._whole else None
        self._p, self._law = there.p, law.bound(fixed, len(self.lane))
        #: Whether something of it lasts where the motion is given: hidden variables, or what laws read of motors.
        self.lasts = bool(e.n_states) or not {"command", "motor"}.isdisjoint(self._names)
        self._index(chunk, motors, dofs[self.site])

    def _index(self, chunk: Chunk, motors: Drives, dof: np.ndarray) -> None:
        """Find the places in the table that it reads and writes."""
        model, index, lane = chunk.robot.model, chunk.table.index, self.lane
        at_site = motors.motors[self.site].T
        place = {"qpos": model.jnt_qposadr[model.dof_jntid[dof]], "dt": np.zeros_like(dof)}
        joint = [index(part, lane, place.get(part, dof)) for part in OWN_ROWS]
        self._take = np.concatenate([np.array(joint), motor_rows(chunk, lane, at_site)])
        self._mounts = mount_rows(self.effect)
        self._rows = np.empty((len(self._take) + self._mounts + self.effect.n_states, len(lane)))
        if self._mounts:
            body = self.effect.bodies(chunk.robot)[self.site]
            self._carrying = (lane, body, dof), carried_dofs(chunk.robot, body)
        self._carried = chunk.carried
        self._added = {name: index(part, lane, dof) for name, part in _ADDED.items()}
        #: For each motor of a site: which instances have it, and where its command and its share stand.
        self._motors = [
            (moved, index("ctrl", lane, command_of(chunk.robot, a))[moved], index("share", lane, a)[moved])
            for a, moved in zip(at_site, motors.there[self.site].T > 0.0, strict=True)
        ]

    def rest(self, table: StepTable) -> np.ndarray:
        """Hidden variables (variables, n) of robots that have been where the table says for long."""
        n = len(self.lane)
        table.take(self._take, self._rows[: len(self._take)])
        return stacked_rows(rest_program(self.effect).bound(self._p, n)(self._rows[0], self._rows[1]), n)

    def act(self, table: StepTable, before: np.ndarray | None) -> np.ndarray:
        """Act in a step; hidden variables (variables, n) after it, of those before."""
        n = len(self.lane)
        table.take(self._take, self._rows[: len(self._take)])
        own = len(self._take) + self._mounts
        if self._mounts and self._carried is not None:
            (lane, body, dof), there = self._carrying
            speed = table["qvel"][lane] * there
            self._rows[len(self._take) : own] = self._carried.mounts(lane, body, dof, speed)
        if before is not None:
            self._rows[own:] = before
        does = iter(self._law(self._rows, *([self._whole.rows(table)] if self._whole else [])))
        for name in self._names:
            if name == "command":
                for moved, command, _ in self._motors:
                    table.put(command, np.broadcast_to(next(does), n)[moved])
            else:
                self._apply(table, name, next(does))
        return stacked_rows(list(does), n)

    def _apply(self, table: StepTable, name: str, x: Any) -> None:
        if name == "motor":
            self.written.add("share")
            for moved, _, share in self._motors:
                table.multiply(share, np.broadcast_to(x, len(self.lane))[moved])
        else:
            self.written.add(_ADDED[name])
            table.add(self._added[name], x)


def _drives(e: Term, chunk: Chunk, dofs: np.ndarray) -> Drives:
    """The motors that count at a term's sites."""
    return drives(chunk.robot, dofs, e.motors(chunk.robot))


def _fixed(chunk: Chunk, there: Instances, motors: Drives) -> SiteFields:
    """What does not change at instances."""
    joint, read, (site, lane, p) = motors.joint[there.site], chunk.models.read, there
    return SiteFields(
        p,
        motor_fields(chunk.models, lane, motors.motors[site].T),
        motors.there[site].T.astype(float),
        read("jnt_actfrclimited")[lane, joint].astype(bool) & motors.whole,
        read("jnt_actfrcrange")[lane, joint],
        motors.limit()[site],
    )


def stacked_rows(rows: Sequence[Any], n: int) -> np.ndarray:
    """Rows, arrays or numbers, as an array (rows, n)."""
    found = np.empty((len(rows), n))
    for k, row in enumerate(rows):
        found[k] = row
    return found
