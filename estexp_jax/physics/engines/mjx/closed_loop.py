"""Closed loop on MJX: one vmapped, jitted batch."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any, final

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from mujoco import mjx

from estexp_jax.physics.effects.base import Distortion
from estexp_jax.physics.effects.catalogue.part_lost import PartLost
from estexp_jax.physics.effects.changes import Values
from estexp_jax.physics.engines.batching import in_chunks
from estexp_jax.physics.engines.closed_loop import (
    BodyState,
    CompiledClosedLoop,
    ReadingOverride,
    RobotInstance,
    Rollout,
    override_reading,
)
from estexp_jax.physics.engines.devices import accelerated, wide
from estexp_jax.physics.engines.mjx.terms import MjxStepStart
from estexp_jax.physics.model.travel import root_position

_WIDTHS = (16, 56)
"""Narrowest and widest chunk: below, a chunk's fixed costs dominate; above, nothing is gained."""
_VECTOR = 8
"""Robots in a chunk are a multiple of this, and one filler."""


@final
@dataclass(frozen=True, eq=False)
class MjxClosedLoop(CompiledClosedLoop):
    """Closed loops on MJX."""

    def _run(self, lanes: RobotInstance, steps: int, *, active: bool, override: ReadingOverride | None) -> Rollout:
        spread, real = _spread(len(lanes.weights), self.width)
        shape = (len(lanes.weights), self.rows, self.interface.n_inputs)
        tables = ReadingOverride(np.ones(shape, np.float32), np.zeros(shape, np.float32))
        for table, given in zip(tables, override or (), strict=False):
            table[:, :steps] = given
        batch = _taken((lanes, tables), spread)
        rollout = in_chunks(lambda part: _rollout_batch(self, part[0], part[1], steps, active), batch, self.width)
        return _taken(rollout, real)


def mjx_width(population: int) -> int:
    """A quarter of the population, so that its new half still fills two chunks, one a core; and the filler.

    On an accelerator, half the population and the filler.
    """
    if accelerated():
        return wide(population, _VECTOR) + 1
    quarter = -(-population // 4)
    return int(np.clip(-(-quarter // _VECTOR) * _VECTOR, *_WIDTHS)) + 1


def _spread(n: int, width: int) -> tuple[np.ndarray, np.ndarray]:
    """Which robot goes where, so that a robot's motion does not depend on its place in the batch.

    XLA steps through a chunk by vectors of robots, but always leaves at least one over for other, scalar code, in which
    a robot moves differently in the last bits; some hundred steps later, by decimetres. With a filler in the last place
    of each chunk every robot takes the vector code, and a diagnosis that is exact predicts the trial exactly.

    Returns:
        The robot in each place (n + fillers,), and the places of the robots (n,).
    """
    robots = np.arange(n)
    places = robots + robots // max(width - 1, 1)
    spread = np.zeros(places[-1] + 1, dtype=int)
    spread[places] = robots
    return spread, places


def _taken(tree: Any, places: np.ndarray) -> Any:
    return jax.tree.map(lambda x: np.asarray(x)[places], tree)


@partial(jax.jit, static_argnums=0)
def _rollout_batch(
    self: MjxClosedLoop, lanes: RobotInstance, override: ReadingOverride, steps: int, active: bool
) -> Rollout:
    return jax.vmap(lambda lane, given: _rollout_one(self, lane, given, steps, active))(lanes, override)


def _rollout_one(
    self: MjxClosedLoop, lane: RobotInstance, override: ReadingOverride, steps: int, active: bool
) -> Rollout:
    """One robot's rollout; what is not the lane's is traced, so that every trial and settling share one executable."""
    model = self.on_mjx.edited(self.on_mjx.model, lane.values)
    controller = self.controller(lane.values, lane.weights)
    travel = root_position(self.robot)
    rows, face = self.rows, self.interface
    rollout = Rollout(
        readings=jnp.zeros((rows, face.n_inputs)),
        commands=jnp.zeros((rows, face.n_outputs)),
        position=jnp.zeros((rows, 3)),
        final=lane.start,
        failed=jnp.asarray(False),
    )

    def control_step(row, carry):  # noqa: ANN001, ANN202
        rollout, hidden = carry
        body = rollout.final
        readings = _readings(self, lane.values, body)
        sensed = override_reading(override.factor[row], override.added[row], readings)
        hidden, outputs = self.policy.respond(controller, hidden, face.inputs(sensed))
        ctrl = jnp.where(active, face.commands(outputs), face.ctrl_centre)
        rollout = rollout._replace(
            readings=rollout.readings.at[row].set(readings),
            commands=rollout.commands.at[row].set(ctrl),
            position=rollout.position.at[row].set(travel(body.qpos)),
            final=jax.lax.fori_loop(
                0, self.substeps, lambda _, b: _physics_step(self, model, lane.values, b, ctrl), body
            ),
        )
        return rollout, hidden

    rollout, _ = jax.lax.fori_loop(0, steps, control_step, (rollout, jnp.zeros(self.policy.n_hidden)))
    return rollout._replace(failed=~(_sound(rollout.final.qpos) & _sound(rollout.final.qvel)))


def _sound(x: jax.Array) -> jax.Array:
    """Whether MuJoCo's C engine would go on with these numbers."""
    return jnp.all(jnp.abs(x) < mujoco.mjMAXVAL)  # false for NaN


def _readings(self: MjxClosedLoop, values: Values, body: BodyState) -> jax.Array:
    """Readings (n_inputs,) as the controller gets them: those of lost parts at rest, faults applied."""
    face = self.interface
    true = face.readings(body.qpos, body.sensordata)
    if PartLost.name in values:
        gone = jnp.clip(values[PartLost.name][:, 0] @ jnp.asarray(face.lost, true.dtype), 0.0, 1.0)
        true = jnp.where(gone > 0.5, face.rest, true)
    whole = body.sensordata.at[face.columns].set(true)
    for effect in self.catalogue:
        if isinstance(effect, Distortion):
            whole = effect.distort(self.robot, whole, values[effect.name])
    return whole[face.columns]


def _physics_step(self: MjxClosedLoop, model: mjx.Model, values: Values, body: BodyState, ctrl: jax.Array) -> BodyState:
    does = self.on_mjx.acted(model, values, body.hidden, _now(self, model, body, ctrl))
    data = self.on_mjx.data.replace(qpos=body.qpos, qvel=body.qvel, qacc_warmstart=body.warmstart)
    data = mjx.step(does.model, data.replace(ctrl=does.ctrl, qfrc_applied=does.force, xfrc_applied=does.pull))
    return BodyState(data.qpos, data.qvel, data.qacc_warmstart, data.sensordata, does.hidden)


def _now(self: MjxClosedLoop, model: mjx.Model, body: BodyState, ctrl: jax.Array) -> MjxStepStart:
    return MjxStepStart(body.qpos, body.qvel, ctrl, jnp.ones(self.interface.n_outputs), model.opt.timestep)
