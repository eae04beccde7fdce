"""Terms and command laws at work in one step, in lanes.

The laws are elementwise; here each joint or motor on which they act is a row of an array (n_elements, N). Those that no
robot of a chunk has are skipped.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, final

import jax
import jax.numpy as jnp
from jax.extend.core import jaxpr_as_fun

from estexp_jax.lanes.algebra import Scalar
from estexp_jax.lanes.forces import MotorCommands
from estexp_jax.lanes.layout import Dof, Layout
from estexp_jax.lanes.model_parameters import ModelParameters
from estexp_jax.lanes.step import AddedForces, LaneState
from estexp_jax.physics.effects.base import Arrays, BodyForce, CommandLaw, Effect, JointForce, Term
from estexp_jax.physics.effects.changes import Values
from estexp_jax.physics.effects.elements import element_values
from estexp_jax.physics.effects.registry import Catalogue
from estexp_jax.physics.effects.sites import driven_actuators
from estexp_jax.physics.engines.lanes.external_wrenches import external_wrenches
from estexp_jax.physics.engines.lanes.joint_states import JointStates, StepStart, stacked
from estexp_jax.physics.engines.lanes.motors import MotorInputs, Motors
from estexp_jax.physics.engines.mjx.terms import Hidden
from estexp_jax.physics.model.robot import Robot


@final
@dataclass
class _Sums:
    """Sums over the terms so far: rows (N,) by address, and factors on the motors by their index."""

    rows: dict[str, dict[int, Scalar]] = field(default_factory=dict)
    share: dict[int, Scalar] = field(default_factory=dict)

    def add(self, what: str, addresses: Sequence[int], x: Any) -> None:
        """Add rows (n_elements, N); a Python number is a default, which adds nothing."""
        if isinstance(x, float):
            return
        table = self.rows.setdefault(what, {})
        for i, address in enumerate(addresses):
            table[address] = table[address] + x[i] if address in table else x[i]


@final
class ActiveEffects:
    """The effects of a catalogue that act during a step, on robots of these numbers."""

    def __init__(
        self, robot: Robot, catalogue: Catalogue, layout: Layout, params: ModelParameters, values: Values
    ) -> None:
        """With values (n_sites, n_parameters, N) of each effect."""
        self._robot, self._layout, self._params, self._values = robot, layout, params, dict(values)
        self._motors = Motors(robot, layout, params)
        self._moments = JointStates(robot, layout, params, self._motors)
        self._terms = [e for e in catalogue if isinstance(e, Term) and e.sites(robot)]
        self._laws = [e for e in catalogue if isinstance(e, CommandLaw) and e.sites(robot)]
        self._body_forces = [e for e in catalogue if isinstance(e, BodyForce) and e.sites(robot)]
        for e in (*self._laws, *self._terms):
            at_sites = jnp.moveaxis(values[e.name], -1, 0)
            self._values[e.name] = jnp.moveaxis(element_values(e, robot, at_sites), 0, -1)
        self._at_work = {e.name: self._is_changed(e) for e in (*self._laws, *self._terms)}

    @property
    def acts(self) -> bool:
        """Whether there are any."""
        return bool(self._terms or self._laws or self._body_forces)

    def act(
        self, state: LaneState, commands: Any, enable: Any, dt: Any, hidden: Hidden
    ) -> tuple[MotorCommands, AddedForces, Hidden]:
        """Motor commands, additions to the joints, and hidden variables after the step.

        Args:
            state: at the beginning of the step.
            commands: (nu, N) in force.
            enable: (nu, N) 1.0 where a motor is on.
            dt: (N,) s, or a number.
            hidden: (n_elements, N) of each effect that has some.
        """
        hidden, rows = dict(hidden), [commands[a] for a in range(commands.shape[0])]
        position, speed = self._moments.coordinates(state)
        if self._laws or self._terms:
            rows = [self._motors.limited(a, row) for a, row in enumerate(rows)]
        for law in self._laws:
            ids = law.actuators(self._robot)
            idle = jnp.stack([self._motors.idle(int(a), position, speed) for a in ids])
            command, before = jnp.stack([rows[a] for a in ids]), hidden.get(law.name, ())
            there, after = self._ruled(law, command, idle, dt, before)
            hidden |= {law.name: after} if law.n_states else {}
            for i, a in enumerate(ids):
                rows[a] = there[i]
        sums = _Sums()
        for term in self._terms:
            now = StepStart(position, speed, MotorInputs(rows, enable, sums.share), dt, state)
            does, after = self._acted(term, now, hidden.get(term.name, ()))
            hidden |= {term.name: after} if term.n_states else {}
            rows = self._gather(term, does, sums, rows)
        on = self._slots([enable[a] for a in range(enable.shape[0])])
        share = self._slots([sums.share.get(a, jnp.ones_like(row)) for a, row in enumerate(rows)])
        return MotorCommands(self._slots(rows), on, share if sums.share else None), self._added(state, sums), hidden

    def rest(self, state: LaneState, commands: Any) -> Hidden:
        """Hidden variables of robots that have been where they are, under commands (nu, N), for long."""
        rows = [self._motors.limited(a, commands[a]) for a in range(commands.shape[0])]
        position, speed = self._moments.coordinates(state)
        hidden: Hidden = {}
        for e in (*self._laws, *self._terms):
            if not e.n_states:
                continue
            p = self._parameters(e.name)
            if isinstance(e, CommandLaw):
                hidden[e.name] = e.initial(p, jnp.stack([rows[a] for a in e.actuators(self._robot)]))
            else:
                hidden[e.name] = e.initial(p, *stacked(e.dofs(self._robot), position, speed))
        return hidden

    def _is_changed(self, e: Effect) -> jax.Array:
        """Whether it is at work in any robot."""
        values = self._values[e.name]
        return jnp.any(values != jnp.array([p.neutral for p in e.parameters], values.dtype)[:, None])

    def _ruled(self, law: CommandLaw, command: Any, idle: Any, dt: Any, before: Arrays) -> tuple[Any, Arrays]:
        """Commands (n_actuators, N) after a law, and its hidden variables after the step."""

        def act() -> tuple[Any, Arrays]:
            return law.act(self._parameters(law.name), command, idle, dt, before)

        return jax.lax.cond(self._at_work[law.name], act, lambda: (command, before))

    def _acted(self, term: Term, now: StepStart, before: Arrays) -> tuple[JointForce, Arrays]:
        """Forces of a term, and its hidden variables after the step."""

        def act() -> tuple[dict[str, Any], Arrays]:
            does, after = term.act(self._parameters(term.name), self._moments.of(term, now), before)
            return {name: x for name, x in does._asdict().items() if not isinstance(x, float)}, after

        program, shapes = jax.make_jaxpr(act, return_shape=True)()

        def run() -> tuple[dict[str, Any], Arrays]:
            return jax.tree.unflatten(jax.tree.structure(shapes), jaxpr_as_fun(program)())

        def skip() -> tuple[dict[str, Any], Arrays]:
            nothing = JointForce()._asdict()
            return {name: jnp.full(x.shape, nothing[name], x.dtype) for name, x in shapes[0].items()}, before

        does, after = jax.lax.cond(self._at_work[term.name], run, skip)
        return JointForce(**does), after

    def _parameters(self, name: str) -> Arrays:
        values = self._values[name]
        return tuple(values[:, i] for i in range(values.shape[1]))

    def _gather(self, term: Term, does: JointForce, sums: _Sums, rows: list[Any]) -> list[Any]:
        """Add what a term does; the commands with what it asks for on top."""
        addresses = [int(d) for d in term.dofs(self._robot)]
        for what in ("force", "damping", "friction", "inertia"):
            sums.add(what, addresses, getattr(does, what))
        if isinstance(does.motor, float) and isinstance(does.command, float):
            return rows
        motors = term.motors(self._robot)
        for i in range(len(addresses)):
            if motors is not None:
                moved = [int(motors[i])]
            else:
                joint = int(self._layout.model.dof_jntid[addresses[i]])
                moved = [a for a in driven_actuators(self._robot) if self._robot.joint_of_actuator(a) == joint]
            if not isinstance(does.command, float):
                rows = self._motors.further(moved, rows, sums.share, does.command[i])
            if not isinstance(does.motor, float):
                sums.share.update({a: sums.share.get(a, 1.0) * does.motor[i] for a in moved})
        return rows

    def _slots(self, rows: list[Any]) -> dict[tuple[int, ...], Any]:
        return {
            motor.ids: rows[motor.ids[0]] if len(motor.ids) == 1 else jnp.stack([rows[a] for a in motor.ids])
            for joint in self._layout.joints
            for motor in joint.motors
        }

    def _added(self, state: LaneState, sums: _Sums) -> AddedForces:
        per_dof = {what: [_collected(dof, table) for dof in self._layout.dofs] for what, table in sums.rows.items()}
        wrenches = (
            external_wrenches(self._robot, self._body_forces, self._layout, self._params, self._values, state)
            if self._body_forces
            else {}
        )
        return AddedForces(
            *(per_dof.get(what, [0] * len(self._layout.dofs)) for what in ("force", "damping", "friction", "inertia")),
            pull=wrenches,
        )


def _collected(dof: Dof, table: dict[int, Scalar]) -> Scalar:
    """Rows (N,) of a group's members as one scalar; 0 where there is none."""
    rows = [table.get(address) for address in dof.addresses]
    there = [row for row in rows if row is not None]
    if not there:
        return 0
    whole = [jnp.zeros_like(there[0]) if row is None else row for row in rows]
    return whole[0] if len(whole) == 1 else jnp.stack(whole)
