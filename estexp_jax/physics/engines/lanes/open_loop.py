"""Open loop in lanes."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any, final

import jax
import jax.numpy as jnp
import mujoco
import numpy as np

from estexp_jax.lanes.compilation import compile_lowered, lower
from estexp_jax.lanes.model_parameters import ModelParameters
from estexp_jax.lanes.sensors import SensorReader
from estexp_jax.lanes.states import from_lanes, to_lanes
from estexp_jax.lanes.step import TOLERANCE, LaneState, Stepper
from estexp_jax.lanes.stored_programs import stored
from estexp_jax.physics.effects.base import Distortion
from estexp_jax.physics.effects.changes import Values
from estexp_jax.physics.effects.registry import is_fixed
from estexp_jax.physics.engines.lanes.model import LanesModel, field_of, lanes_model
from estexp_jax.physics.engines.lanes.terms import ActiveEffects
from estexp_jax.physics.engines.mjx.edited_open_loop import EditedOpenLoop
from estexp_jax.physics.engines.mjx.terms import Hidden
from estexp_jax.physics.engines.motor_readings import motor_readings
from estexp_jax.physics.engines.open_loop_inputs import CommandSteps, RolledRows
from estexp_jax.physics.engines.open_loop_states import LaneBatchState, StepReadings
from estexp_jax.physics.window import Window

LANES_REPLAY = 200, 32
"""Lanes in a chunk, and physics steps in a call: XLA copies a call's rows at each step, so they are few."""


@final
@dataclass(frozen=True, eq=False)
class LanesOpenLoop(EditedOpenLoop):
    """Open loops in lanes."""

    _lock: threading.Lock = field(default_factory=threading.Lock)
    _programs: dict[str, Any] = field(default_factory=dict)

    @cached_property
    def lanes(self) -> LanesModel:
        """The robot in lanes."""
        return lanes_model(self.on_mjx, self.differing.fields)

    def _prepared(self, values: Values, windows: Sequence[Window]) -> Any:
        overrides = self.overrides([s.recording for s in windows])

        def compile_it(label: str) -> Any:
            return lower(jax.vmap(self._edited, out_axes=-1), values, overrides, label=label).compile()

        return self._program("prepare", compile_it, values, overrides)(values, overrides)

    def _edited(self, values: Values, overrides: tuple) -> Any:
        model = self.model(values, overrides)
        return {name: field_of(model, name) for name in self.lanes.written}, values

    def _rested(self, prepared: Any, roll: RolledRows) -> Hidden:
        def compile_it(label: str) -> Any:
            return lower(self._resting, prepared, roll, label=label).compile()

        return self._program("rest", compile_it, prepared, roll)(prepared, roll)

    def _rolled(self, prepared: Any, hidden: Hidden, roll: RolledRows) -> Hidden:
        def compile_it(label: str) -> Any:
            return compile_lowered(lower(self._rolling, prepared, hidden, roll, label=label), self.width)[0]

        return self._program("roll", compile_it, prepared, hidden, roll)(prepared, hidden, roll)

    def _advanced(
        self, prepared: Any, state: LaneBatchState, drive: CommandSteps
    ) -> tuple[LaneBatchState, StepReadings]:
        carried = LaneBatchState._make([*map(_lanes_last, state[:-1]), state.hidden])
        first = CommandSteps(*(x[: self.block] for x in drive))

        def compile_it(label: str) -> Any:
            return compile_lowered(lower(self._blocked, prepared, carried, first, label=label), self.width)[0]

        advance, outputs = self._program("block", compile_it, prepared, carried, first), []
        for begin in range(0, len(drive.length), self.block):
            carried, out = advance(prepared, carried, CommandSteps(*(x[begin : begin + self.block] for x in drive)))
            outputs.append(out)
        whole = (np.concatenate([np.asarray(x) for x in kind]) for kind in zip(*outputs, strict=True))
        after = [np.moveaxis(np.asarray(x), -1, 0) for x in carried[:-1]]
        return LaneBatchState._make([*after, carried.hidden]), StepReadings(*whole)

    def _program(self, name: str, compile_it: Callable[[str], Any], *arguments: Any) -> Any:
        """A program for such arguments, the first time from the disk or compiled."""
        with self._lock:
            if name not in self._programs:
                own = self._identity
                found = compile_it("") if own is None else stored([name.encode(), *own], arguments, compile_it)
                self._programs[name] = found
        return self._programs[name]

    @cached_property
    def _identity(self) -> list[bytes] | None:
        """All that programs are made from; None where effects are not this package's own, and so may change."""
        if any(not is_fixed(e) for e in self.catalogue):
            return None
        models = [_saved(model) for model in (self.robot.model, self.on_mjx.armed)]
        leaves = jax.tree.leaves(self.on_mjx.model)
        shapes = [(np.shape(x), np.asarray(x).dtype.name) for x in leaves]
        names, differing = [e.name for e in self.catalogue], (self.differing.positions, sorted(self.differing.fields))
        own = repr((names, self.width, self.block, shapes, differing))
        return [own.encode(), *models, *(np.asarray(x).tobytes() for x in leaves)]

    def _resting(self, prepared: Any, roll: RolledRows) -> Hidden:
        _, acting = self._acting(prepared, roll.qpos.dtype)
        return acting.rest(to_lanes(self.lanes.layout, roll.qpos, roll.qvel, roll.qvel), roll.ctrl)

    def _rolling(self, prepared: Any, hidden: Hidden, roll: RolledRows) -> Hidden:
        _, acting = self._acting(prepared, roll.qpos.dtype)

        def step(hidden: Hidden, now: RolledRows) -> tuple[Hidden, None]:
            there = to_lanes(self.lanes.layout, now.qpos, now.qvel, now.qvel)
            _, _, after = acting.act(there, now.ctrl, now.enable, now.length, hidden)
            return jax.tree.map(partial(jnp.where, now.length > 0.0), after, hidden), None

        return jax.lax.scan(step, hidden, roll)[0]

    def _acting(self, prepared: Any, dtype: Any) -> tuple[ModelParameters, ActiveEffects]:
        (fields, values), layout = prepared, self.lanes.layout
        params = ModelParameters(layout.model, fields, dtype)
        return params, ActiveEffects(self.robot, self.catalogue, layout, params, values)

    def _blocked(self, prepared: Any, state: LaneBatchState, drive: CommandSteps) -> Any:
        (_, values), layout = prepared, self.lanes.layout
        params, acting = self._acting(prepared, state.qpos.dtype)
        stepper = Stepper(layout, params, TOLERANCE[np.dtype(state.qpos.dtype)])
        reader = SensorReader(layout, params, stepper.inertias)
        motor_sensors = motor_readings(self.robot, self.catalogue)

        def step(carry: tuple[LaneState, Hidden], now: CommandSteps) -> Any:
            lanes, hidden = carry
            left: jax.Array = now.length
            moves = left > 0.0
            length = jnp.where(moves, left, layout.model.opt.timestep).astype(left.dtype)
            qpos, qvel, _ = from_lanes(layout, lanes)
            commands, added, after = acting.act(lanes, now.ctrl, now.enable, length, hidden)
            stepped, instant = stepper.step(lanes, commands, length, added)
            lanes, hidden = jax.tree.map(partial(jnp.where, moves), (stepped, after), (lanes, hidden))
            read = reader.read(instant, range(layout.model.nsensor))
            sensed = (
                state.qpos[:0] if not read else jnp.stack([read[i] + jnp.zeros_like(qpos[0]) for i in sorted(read)])
            )
            for s in motor_sensors:
                sensed = sensed.at[s.column].add(s.factor * after[s.effect][s.state][s.row])
            return (lanes, hidden), (sensed, qpos, qvel)

        start = (to_lanes(layout, state.qpos, state.qvel, state.warmstart), state.hidden)
        (lanes, hidden), (sensors, qpos, qvel) = jax.lax.scan(step, start, drive)
        for effect in self.catalogue:
            if isinstance(effect, Distortion):
                distort = jax.vmap(lambda x, v, e=effect: e.distort(self.robot, x, v), in_axes=-1, out_axes=-1)
                sensors = distort(sensors, values[effect.name])
        after = from_lanes(layout, lanes)
        return LaneBatchState(after[0], after[1], state.act, after[2], hidden), (sensors, qpos, qvel)


def _saved(model: mujoco.MjModel) -> bytes:
    found = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, found)
    return found.tobytes()


def _lanes_last(x: Any) -> np.ndarray:
    return np.ascontiguousarray(np.moveaxis(np.asarray(x), 0, -1))
