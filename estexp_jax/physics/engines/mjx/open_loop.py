"""Open loop on MJX: one vmapped, jitted batch a block."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, final

import jax
import jax.numpy as jnp
import numpy as np
from mujoco import mjx

from estexp_jax.physics.effects.base import Distortion
from estexp_jax.physics.effects.changes import Values
from estexp_jax.physics.engines.mjx.edited_open_loop import EditedOpenLoop
from estexp_jax.physics.engines.mjx.model import with_motors_switched, with_timestep
from estexp_jax.physics.engines.mjx.terms import Hidden, MjxStepStart
from estexp_jax.physics.engines.motor_readings import motor_readings
from estexp_jax.physics.engines.open_loop_inputs import CommandSteps, RolledRows
from estexp_jax.physics.engines.open_loop_states import LaneBatchState, StepReadings
from estexp_jax.physics.window import Window

MJX_REPLAY = 64, 256
"""Lanes in a chunk, and physics steps in a call."""


@final
@dataclass(frozen=True, eq=False)
class MjxOpenLoop(EditedOpenLoop):
    """Open loops on MJX; equal are those that share their compiled programs."""

    def __eq__(self, other: object) -> bool:
        return isinstance(other, MjxOpenLoop) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)

    @property
    def _key(self) -> tuple[int, ...]:
        return id(self.on_mjx), id(self.differing), id(self.robot), self.width, self.block

    def _prepared(self, values: Values, windows: Sequence[Window]) -> Any:
        return values, self.overrides([s.recording for s in windows])

    def _rested(self, prepared: Any, roll: RolledRows) -> Hidden:
        return _rested(self, *prepared, RolledRows(*map(_lanes_first, roll)))

    def _rolled(self, prepared: Any, hidden: Hidden, roll: RolledRows) -> Hidden:
        return _rolled(self, *prepared, hidden, RolledRows(*map(_lanes_first, roll)))

    def _advanced(
        self, prepared: Any, state: LaneBatchState, drive: CommandSteps
    ) -> tuple[LaneBatchState, StepReadings]:
        outputs, drive = [], CommandSteps(*map(_lanes_first, drive))
        for first in range(0, drive.length.shape[1], self.block):
            part = CommandSteps(*(x[:, first : first + self.block] for x in drive))
            state, out = _block(self, *prepared, state, part)
            outputs.append(out)
        whole = (
            np.moveaxis(np.concatenate([np.asarray(x) for x in kind], axis=1), 0, -1)
            for kind in zip(*outputs, strict=True)
        )
        return state, StepReadings(*whole)


@partial(jax.jit, static_argnums=0)
def _block(self: MjxOpenLoop, values: Values, overrides: tuple, state: LaneBatchState, drive: CommandSteps) -> Any:
    return jax.vmap(partial(_block_one, self))(values, overrides, state, drive)


def _block_one(self: MjxOpenLoop, values: Values, overrides: tuple, state: LaneBatchState, drive: CommandSteps) -> Any:
    """One lane's block: its state after it, and (sensors, qpos, qvel) at the beginning of each step."""
    model = self.model(values, overrides)

    def step(state: LaneBatchState, now: CommandSteps):  # noqa: ANN202
        length = jnp.where(now.length > 0.0, now.length, self.robot.model.opt.timestep)
        data, hidden = _step(self, model, values, state, now._replace(length=length))
        sensors: Any = data.sensordata
        for effect in self.catalogue:
            if isinstance(effect, Distortion):
                sensors = effect.distort(self.robot, sensors, values[effect.name])
        after = LaneBatchState(data.qpos, data.qvel, data.act, data.qacc_warmstart, hidden)
        after = jax.tree.map(partial(jnp.where, now.length > 0.0), after, state)
        return after, (sensors, state.qpos, state.qvel)

    return jax.lax.scan(step, state, drive)


def _step(
    self: MjxOpenLoop, model: mjx.Model, values: Values, state: LaneBatchState, drive: CommandSteps
) -> tuple[mjx.Data, Hidden]:
    model = with_motors_switched(model.replace(opt=model.opt.replace(timestep=drive.length)), drive.enable)
    now = MjxStepStart(state.qpos, state.qvel, drive.ctrl, drive.enable, drive.length)
    does = self.on_mjx.acted(model, values, state.hidden, now)
    data = self.on_mjx.data.replace(qpos=state.qpos, qvel=state.qvel, act=state.act, qacc_warmstart=state.warmstart)
    after = with_timestep(does, data)
    for s in motor_readings(self.robot, self.catalogue):
        torque = s.factor * does.hidden[s.effect][s.state][s.row]
        after = after.replace(sensordata=after.sensordata.at[s.column].add(torque))
    return after, does.hidden


@partial(jax.jit, static_argnums=0)
def _rested(self: MjxOpenLoop, values: Values, overrides: tuple, roll: RolledRows) -> Hidden:
    def one(values: Values, overrides: tuple, roll: RolledRows) -> Hidden:
        return self.on_mjx.rested(self.model(values, overrides), values, MjxStepStart(*roll))

    return jax.vmap(one)(values, overrides, roll)


@partial(jax.jit, static_argnums=0)
def _rolled(self: MjxOpenLoop, values: Values, overrides: tuple, hidden: Hidden, roll: RolledRows) -> Hidden:
    """Hidden variables after the rows of a roll, along which the robot moved as recorded."""

    def one(values: Values, overrides: tuple, hidden: Hidden, roll: RolledRows) -> Hidden:
        model = self.model(values, overrides)

        def step(hidden: Hidden, now: RolledRows) -> tuple[Hidden, None]:
            switched_model = with_motors_switched(model, now.enable)
            after = self.on_mjx.acted(switched_model, values, hidden, MjxStepStart(*now)).hidden
            return jax.tree.map(partial(jnp.where, now.length > 0.0), after, hidden), None

        return jax.lax.scan(step, hidden, roll)[0]

    return jax.vmap(one)(values, overrides, hidden, roll)


def _lanes_first(x: Any) -> np.ndarray:
    return np.moveaxis(x, -1, 0)
