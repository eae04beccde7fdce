"""The closed loop in lanes: sensors, controller, motors, physics, over and over."""

from __future__ import annotations

from typing import Any, NamedTuple, final

import jax
import jax.numpy as jnp
import mujoco
import numpy as np

from estexp_jax.lanes.algebra import add, total
from estexp_jax.lanes.forces import MotorCommands, motor_commands
from estexp_jax.lanes.model_parameters import ModelParameters
from estexp_jax.lanes.sensors import SensorReader
from estexp_jax.lanes.states import configuration_of, from_lanes, to_lanes
from estexp_jax.lanes.step import TOLERANCE, LaneState, Stepper
from estexp_jax.physics.effects.changes import Values
from estexp_jax.physics.engines.closed_loop import BodyState, ClosedLoopSimulator, override_reading
from estexp_jax.physics.engines.lanes.model import LanesModel
from estexp_jax.physics.engines.lanes.terms import ActiveEffects
from estexp_jax.physics.engines.mjx.terms import Hidden
from estexp_jax.physics.model.travel import root_position_map

ROWS = 25
"""Control steps in a call: XLA copies the rows of a call at each of its steps, so they are few."""


class Batch(NamedTuple):
    """Inputs of a rollout, robots last."""

    fields: dict[str, Any]  #: numbers that differ from robot to robot
    values: Values
    controller: Any  #: parameters, as `Policy.prepare_lanes` gives them
    lost: Any  #: (n_inputs, N) bool: sensors of lost parts
    scale: Any  #: (n_inputs, N) by what faulty sensors multiply
    shift: Any  #: (n_inputs, N) what they add
    start: BodyState


class NetworkInputs(NamedTuple):
    """Inputs that controllers get from outside, for one call."""

    factor: Any  #: (ROWS, n_inputs, N) by what the robots' own readings are multiplied; 0 where they do not count
    added: Any  #: (ROWS, n_inputs, N)
    active: Any  #: bool; false: all motors at home


class Block(NamedTuple):
    """Results of one call, robots last."""

    final: BodyState
    neurons: Any  #: (n_hidden, N)
    rows: Any  #: (ROWS, n_inputs + n_outputs + 3, N): readings, commands, position; only the steps taken are filled


class _Carry(NamedTuple):
    state: LaneState
    felt: tuple[Any, ...]  # of each touch sensor, (N,)
    hidden: Hidden
    neurons: tuple[Any, ...]
    rows: Any


@final
class ControlLoop:
    """Robots of one chunk, each driven by its own controller."""

    def __init__(self, simulator: ClosedLoopSimulator, lanes: LanesModel, batch: Batch) -> None:
        """For a batch; made while a rollout is traced."""
        self._simulator, self._face, self._layout, self._batch = simulator, simulator.interface, lanes.layout, batch
        self._dtype, self._n = batch.start.qpos.dtype, batch.start.qpos.shape[1]
        params = ModelParameters(self._layout.model, batch.fields, self._dtype)
        self._stepper = Stepper(self._layout, params, TOLERANCE[np.dtype(self._dtype)])
        self._reader = SensorReader(self._layout, params, self._stepper.inertias)
        self._acting = ActiveEffects(simulator.robot, simulator.catalogue, self._layout, params, batch.values)
        kinds, touch = self._layout.model.sensor_type, int(mujoco.mjtSensor.mjSENS_TOUCH)
        self._touches = np.flatnonzero(kinds == touch).tolist()
        self._travel = root_position_map(simulator.robot)

    def advance(self, neurons: Any, steps: Any, inputs: NetworkInputs) -> Block:
        """The robots some control steps later.

        Args:
            neurons: (n_hidden, N) the controllers' hidden states.
            steps: at most `ROWS`.
            inputs: from outside.
        """
        start, face = self._batch.start, self._face
        columns = self._layout.model.sensor_adr[self._touches].tolist()
        carry = _Carry(
            to_lanes(self._layout, start.qpos, start.qvel, start.warmstart),
            tuple(start.sensordata[c] for c in columns),
            start.hidden,
            tuple(neurons[i] for i in range(self._simulator.policy.n_hidden)),
            jnp.zeros((ROWS, face.n_inputs + face.n_outputs + 3, self._n), self._dtype),
        )
        carry = jax.lax.fori_loop(0, steps, lambda row, c: self._control_step(row, c, inputs), carry)
        sensordata = start.sensordata
        for column, felt in zip(columns, carry.felt, strict=True):
            sensordata = sensordata.at[column].set(felt)
        final = BodyState(*from_lanes(self._layout, carry.state), sensordata, carry.hidden)
        return Block(final, jnp.stack(carry.neurons), carry.rows)

    def _control_step(self, row: Any, carry: _Carry, inputs: NetworkInputs) -> _Carry:
        qpos = configuration_of(self._layout, carry.state)
        readings = self._readings(qpos, carry.felt)
        sensed = [override_reading(inputs.factor[row, i], inputs.added[row, i], r) for i, r in enumerate(readings)]
        neurons, outputs = self._simulator.policy.respond_lanes(
            self._batch.controller, carry.neurons, self._inputs(sensed)
        )
        commands = [self._command(i, u, inputs.active) for i, u in enumerate(outputs)]
        table = jnp.stack(commands)
        inner = (carry.state, carry.felt, carry.hidden)
        drive, on = motor_commands(self._layout, commands), jnp.ones_like(table)
        state, felt, hidden = jax.lax.fori_loop(
            0, self._simulator.substeps, lambda _, x: self._physics_step(x, drive, table, on), inner
        )
        return _Carry(
            state,
            felt,
            hidden,
            tuple(neurons),
            carry.rows.at[row].set(jnp.stack([*readings, *commands, *self._place(qpos)])),
        )

    def _physics_step(self, inner: tuple[LaneState, Any, Hidden], drive: MotorCommands, commands: Any, on: Any) -> Any:
        state, _, hidden = inner
        added, dt = None, float(self._layout.model.opt.timestep)
        if self._acting.acts:
            drive, added, hidden = self._acting.act(state, commands, on, dt, hidden)
        state, now = self._stepper.step(state, drive, dt, added)
        return state, tuple(self._reader.read(now, self._touches).values()), hidden

    def _command(self, i: int, output: Any, active: Any) -> Any:
        """As `Interface.commands`; home where the networks are not active."""
        face = self._face
        centre = jnp.full_like(output, face.ctrl_centre[i])
        moved = jnp.clip(centre + float(face.ctrl_scale[i]) * output, float(face.ctrl_low[i]), float(face.ctrl_high[i]))
        return jnp.where(active, moved, centre)

    def _readings(self, qpos: list[Any], felt: tuple[Any, ...]) -> list[Any]:
        """Readings as the controllers get them: those of lost parts at rest, faults applied."""
        face, batch = self._face, self._batch
        columns = self._layout.model.sensor_adr[self._touches].tolist()
        found = []
        for i, column in enumerate(face.columns.tolist()):
            if face.is_touch[i]:
                true: Any = jnp.where(felt[columns.index(column)] > 0.0, 1.0, -1.0).astype(self._dtype)
            else:
                true = qpos[int(face.qpos[i])]
            true = jnp.where(batch.lost[i], jnp.full_like(true, face.rest[i]), true)
            found.append(true * batch.scale[i] + batch.shift[i])
        return found

    def _inputs(self, readings: list[Any]) -> list[Any]:
        face = self._face
        return [
            jnp.clip((r - float(c)) / float(s), -1.0, 1.0)
            for r, c, s in zip(readings, face.centre, face.scale, strict=True)
        ]

    def _place(self, qpos: list[Any]) -> list[Any]:
        """Positions of the roots, m."""
        matrix, offset = self._travel
        zero = jnp.zeros(self._n, self._dtype)
        return [
            add(total(float(m) * q for m, q in zip(row, qpos, strict=True) if m), float(o)) + zero
            for row, o in zip(matrix, offset, strict=True)
        ]
