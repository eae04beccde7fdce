"""Open loop on MJX: one vmapped, jitted batch a block."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any, final

import jax
import jax.numpy as jnp
import numpy as np
from mujoco import mjx

from estexp_jax.physics.effects.base import Distortion
from estexp_jax.physics.effects.changes import Values
from estexp_jax.physics.engines.mjx.model import stepped, switched
from estexp_jax.physics.engines.mjx.terms import Hidden, Now
from estexp_jax.physics.engines.motor_readings import shown_torques
from estexp_jax.physics.engines.open_loop import Replayer, Seen, State, is_acceleration
from estexp_jax.physics.engines.open_loop_inputs import Drive, Roll

MJX_REPLAY = 64, 256
"""Lanes in a chunk, and physics steps in a call."""


@final
@dataclass(frozen=True, eq=False)
class MjxReplayer(Replayer):
    """A replayer on MJX."""

    def _prepared(self, values: Values, overrides: tuple) -> Any:
        return values, overrides

    def _rested(self, prepared: Any, roll: Roll) -> Hidden:
        return _rested(self, *prepared, Roll(*map(_lanes_first, roll)))

    def _rolled(self, prepared: Any, hidden: Hidden, roll: Roll) -> Hidden:
        return _rolled(self, *prepared, hidden, Roll(*map(_lanes_first, roll)))

    def _advanced(self, prepared: Any, state: State, drive: Drive) -> tuple[State, Seen]:
        seen, drive = [], Drive(*map(_lanes_first, drive))
        for first in range(0, drive.length.shape[1], self.block):
            part = Drive(*(x[:, first : first + self.block] for x in drive))
            state, out = _block(self, *prepared, state, part)
            seen.append(out)
        whole = (
            np.moveaxis(np.concatenate([np.asarray(x) for x in kind], axis=1), 0, -1)
            for kind in zip(*seen, strict=True)
        )
        return state, Seen(*whole)


@partial(jax.jit, static_argnums=0)
def _block(self: MjxReplayer, values: Values, overrides: tuple, state: State, drive: Drive) -> Any:
    return jax.vmap(partial(_block_one, self))(values, overrides, state, drive)


def _block_one(self: MjxReplayer, values: Values, overrides: tuple, state: State, drive: Drive) -> Any:
    """One lane's block: its state after it, and (sensors, qpos, qvel) at the beginning of each step."""
    model = self.model(values, overrides)
    # Position and velocity sensors read the state a step begins with; force and acceleration sensors what acted before.
    before = jnp.asarray(is_acceleration(self.robot))

    def step(state: State, now: Drive):  # noqa: ANN202
        length = jnp.where(now.length > 0.0, now.length, self.robot.model.opt.timestep)
        data, hidden = _step(self, model, values, state, now._replace(length=length))
        sensors: Any = jnp.where(before, state.sensordata, data.sensordata)
        for effect in self.catalogue:
            if isinstance(effect, Distortion):
                sensors = effect.distort(self.robot, sensors, values[effect.name])
        after = State(data.qpos, data.qvel, data.act, data.qacc_warmstart, data.sensordata, hidden)
        after = jax.tree.map(partial(jnp.where, now.length > 0.0), after, state)._replace(sensordata=data.sensordata)
        return after, (sensors, state.qpos, state.qvel)

    return jax.lax.scan(step, state, drive)


def _step(self: MjxReplayer, model: mjx.Model, values: Values, state: State, drive: Drive) -> tuple[mjx.Data, Hidden]:
    model = switched(model.replace(opt=model.opt.replace(timestep=drive.length)), drive.enable)
    now = Now(state.qpos, state.qvel, drive.ctrl, drive.enable, drive.length)
    does = self.on_mjx.acted(model, values, state.hidden, now)
    data = self.on_mjx.data.replace(qpos=state.qpos, qvel=state.qvel, act=state.act, qacc_warmstart=state.warmstart)
    after = stepped(does, data)
    for s in shown_torques(self.robot, self.catalogue):
        torque = s.factor * does.hidden[s.effect][s.state][s.row]
        after = after.replace(sensordata=after.sensordata.at[s.column].add(torque))
    return after, does.hidden


@partial(jax.jit, static_argnums=0)
def _rested(self: MjxReplayer, values: Values, overrides: tuple, roll: Roll) -> Hidden:
    def one(values: Values, overrides: tuple, roll: Roll) -> Hidden:
        return self.on_mjx.rested(self.model(values, overrides), values, Now(*roll))

    return jax.vmap(one)(values, overrides, roll)


@partial(jax.jit, static_argnums=0)
def _rolled(self: MjxReplayer, values: Values, overrides: tuple, hidden: Hidden, roll: Roll) -> Hidden:
    """Hidden variables after the rows of a roll, along which the robot moved as recorded."""

    def one(values: Values, overrides: tuple, hidden: Hidden, roll: Roll) -> Hidden:
        model = self.model(values, overrides)

        def step(hidden: Hidden, now: Roll) -> tuple[Hidden, None]:
            switched_model = switched(model, now.enable)
            after = self.on_mjx.acted(switched_model, values, hidden, Now(*now)).hidden
            return jax.tree.map(partial(jnp.where, now.length > 0.0), after, hidden), None

        return jax.lax.scan(step, hidden, roll)[0]

    return jax.vmap(one)(values, overrides, hidden, roll)


def _lanes_first(x: Any) -> np.ndarray:
    return np.moveaxis(x, -1, 0)
