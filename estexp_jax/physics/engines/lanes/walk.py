"""Closed loop in lanes."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple, final

import jax
import jax.numpy as jnp
import mujoco
import numpy as np

from estexp_jax.physics.changes import Values
from estexp_jax.physics.controllers import HIDDEN, Network
from estexp_jax.physics.effects.base import Distortion
from estexp_jax.physics.engines.batching import cores, in_chunks
from estexp_jax.physics.engines.lanes.forces import Drive
from estexp_jax.physics.engines.lanes.model import LanesModel, lanes_model
from estexp_jax.physics.engines.lanes.numbers import Numbers
from estexp_jax.physics.engines.lanes.sensors import Reader
from estexp_jax.physics.engines.lanes.states import packed, unpacked
from estexp_jax.physics.engines.lanes.step import LaneState, Stepper
from estexp_jax.physics.engines.lanes.terms import Acting
from estexp_jax.physics.engines.lanes.xla import compiled
from estexp_jax.physics.engines.mjx_terms import Hidden
from estexp_jax.physics.engines.walking import BodyState, Lane, Walk, Walker
from estexp_jax.physics.travel import travel_map

_VECTOR = 8
"""Robots in a chunk are a multiple of this, so that all take the same vector code and none depends on its place."""
_WIDEST = 104
TOLERANCE = {np.dtype(np.float32): 1e-9, np.dtype(np.float64): 1e-22}
"""Squared relative change of the accelerations at which the solver stops."""


def lanes_width(population: int) -> int:
    """Robots in a chunk: a share of half the population for each core, at most as many as stay in the cache.

    Multiples of 32 are left out: arrays a power of two apart fall on the same lines of the cache.
    """
    share = -(-population // (2 * cores()))
    width = int(np.clip(-(-share // _VECTOR) * _VECTOR, _VECTOR, _WIDEST))
    return width + _VECTOR if width % 32 == 0 else width


class _Batch(NamedTuple):
    """What a rollout takes, robots last."""

    fields: dict[str, Any]
    values: Values
    network: Network
    lost: Any  # (n_inputs, N) bool: sensors of lost parts
    start: BodyState


class _Carry(NamedTuple):
    state: LaneState
    felt: Any  # (nsensordata, N)
    hidden: Hidden
    neurons: tuple[Any, ...]
    readings: Any
    commands: Any
    position: Any


@final
@dataclass(frozen=True, eq=False)
class LanesWalker(Walker):
    """A walker in lanes."""

    _lock: threading.Lock = field(default_factory=threading.Lock, init=False)
    _programs: dict[str, Any] = field(default_factory=dict, init=False)

    @cached_property
    def lanes(self) -> LanesModel:
        """The robot in lanes."""
        return lanes_model(self.on_mjx)

    @property
    def fast(self) -> bool:
        """Whether XLA compiled the walk with the options that make it fast; after the first walk."""
        return self._programs["fast"]

    def _run(self, lanes: Lane, steps: int, *, active: bool) -> Walk:
        batch = jax.tree.map(np.asarray, lanes)
        return in_chunks(lambda part: self._chunk(part, steps, active), batch, self.width)

    def _chunk(self, lanes: Lane, steps: int, active: bool) -> Walk:
        prepare, walk = self._compiled(lanes)
        found = walk(prepare(lanes), np.int32(steps), np.bool_(active))
        return jax.tree.map(lambda x: np.moveaxis(np.asarray(x), -1, 0), found)

    def _compiled(self, lanes: Lane) -> tuple[Any, Any]:
        """Both executables, compiled at the first call."""
        with self._lock:
            if not self._programs:
                prepare = jax.jit(jax.vmap(self._prepared, out_axes=-1)).lower(lanes)
                batch = prepare.out_info
                walk = jax.jit(self._walked).lower(batch, np.int32(0), np.bool_(True))
                with ThreadPoolExecutor(1) as other:
                    preparing = other.submit(prepare.compile)
                    self._programs["walk"], self._programs["fast"] = compiled(walk)
                    self._programs["prepare"] = preparing.result()
        return self._programs["prepare"], self._programs["walk"]

    def _prepared(self, lane: Lane) -> _Batch:
        """What does not change in a rollout, for one robot."""
        network = self.network(lane)
        network = network._replace(w_output=network.w_output[network.output_of])
        lost = jnp.zeros(self.interface.n_inputs, bool)
        if "part_lost" in lane.values:
            lost = lane.values["part_lost"][:, 0] @ jnp.asarray(self.interface.lost, jnp.float32) > 0.5
        return _Batch(self.lanes.fields(self.on_mjx.model, lane.values), lane.values, network, lost, lane.start)

    def _walked(self, batch: _Batch, steps: Any, active: Any) -> Walk:
        """All robots' walks."""
        plan, face, start = self.lanes.plan, self.interface, batch.start
        numbers = Numbers(plan.model, batch.fields, start.qpos.dtype)
        stepper = Stepper(plan, numbers, TOLERANCE[np.dtype(start.qpos.dtype)])
        reader = Reader(plan, numbers, stepper.inertias)
        acting = Acting(self.robot, self.catalogue, plan, numbers, batch.values)
        acts, dt = acting.acts, float(plan.model.opt.timestep)
        touches = [s for s in range(plan.model.nsensor) if plan.model.sensor_type[s] == mujoco.mjtSensor.mjSENS_TOUCH]
        matrix, offset = travel_map(self.robot)
        n = start.qpos.shape[1]

        def control_step(row: Any, carry: _Carry) -> _Carry:
            qpos, _, _ = unpacked(plan, carry.state)
            readings = self._readings(batch, qpos, carry.felt)
            neurons, outputs = _respond(batch.network, carry.neurons, _inputs(face, readings), self.gain)
            each: list[Any] = [
                jnp.where(active, jnp.clip(c + s * u, low, high), c)
                for u, c, s, low, high in zip(
                    outputs,
                    *(x.astype(np.float32) for x in (face.ctrl_centre, face.ctrl_scale, face.ctrl_low, face.ctrl_high)),
                    strict=True,
                )
            ]
            drive = Drive({m.ids: _stacked(each, m.ids) for j in plan.joints for m in j.motors})
            commands = jnp.stack(each)
            on = jnp.ones_like(commands)

            def physics_step(_: Any, inner: tuple[LaneState, Any, Hidden]) -> tuple[LaneState, Any, Hidden]:
                state, felt, hidden = inner
                told, added, hidden = acting.act(state, commands, on, dt, hidden) if acts else (drive, None, hidden)
                state, now = stepper.step(state, told, dt, added)
                for address, x in reader.read(now, touches).items():
                    felt = felt.at[address].set(x)
                return state, felt, hidden

            inner = (carry.state, carry.felt, carry.hidden)
            state, felt, hidden = jax.lax.fori_loop(0, self.substeps, physics_step, inner)
            place = jnp.asarray(matrix, qpos.dtype) @ qpos + jnp.asarray(offset, qpos.dtype)[:, None]
            return _Carry(
                state,
                felt,
                hidden,
                tuple(neurons),
                carry.readings.at[row].set(readings),
                carry.commands.at[row].set(commands),
                carry.position.at[row].set(place),
            )

        carry = _Carry(
            packed(plan, start.qpos, start.qvel, start.warmstart),
            start.sensordata,
            start.hidden,
            tuple(jnp.zeros(n, start.qpos.dtype) for _ in range(HIDDEN)),
            *(jnp.zeros((self.rows, k, n), start.qpos.dtype) for k in (face.n_inputs, face.n_outputs, 3)),
        )
        carry = jax.lax.fori_loop(0, steps, control_step, carry)
        final = BodyState(*unpacked(plan, carry.state), carry.felt, carry.hidden)
        sound = jnp.all(jnp.abs(final.qpos) < mujoco.mjMAXVAL, axis=0)  # false for NaN
        sound &= jnp.all(jnp.abs(final.qvel) < mujoco.mjMAXVAL, axis=0)
        return Walk(carry.readings, carry.commands, carry.position, final, ~sound)

    def _readings(self, batch: _Batch, qpos: Any, felt: Any) -> Any:
        """Readings (n_inputs, N) as the controllers get them: those of lost parts at rest, faults applied."""
        face = self.interface
        touch = jnp.where(felt[face.columns] > 0.0, 1.0, -1.0).astype(felt.dtype)
        true: Any = jnp.where(face.is_touch[:, None], touch, qpos[face.qpos])
        true = jnp.where(batch.lost, jnp.asarray(face.rest, true.dtype)[:, None], true)
        faults = [e for e in self.catalogue if isinstance(e, Distortion)]
        if not faults:
            return true
        whole = felt.at[face.columns].set(true)
        for effect in faults:
            distort = jax.vmap(lambda x, v, e=effect: e.distort(self.robot, x, v), in_axes=-1, out_axes=-1)
            whole = distort(whole, batch.values[effect.name])
        return whole[face.columns]


def _inputs(face: Any, readings: Any) -> Any:
    centre, scale = (jnp.asarray(x, readings.dtype)[:, None] for x in (face.centre, face.scale))
    return jnp.clip((readings - centre) / scale, -1.0, 1.0)


def _stacked(rows: list[Any], members: tuple[int, ...]) -> Any:
    return rows[members[0]] if len(members) == 1 else jnp.stack([rows[m] for m in members])


def _respond(network: Network, hidden: tuple[Any, ...], inputs: Any, gain: float) -> tuple[list[Any], list[Any]]:
    """As `controllers.respond`, each neuron one array (N,); motors that repeat others have those's weights."""
    n_inputs = inputs.shape[0]

    def neuron(weights: Any, xs: list[Any]) -> Any:
        drive = weights[len(xs)] if weights.shape[0] > len(xs) else 0.0
        return drive + sum(weights[i] * x for i, x in enumerate(xs))

    xs = [inputs[i] for i in range(n_inputs)]
    drives = [neuron(network.w_hidden[h], xs) + neuron(network.w_recurrent[h], list(hidden)) for h in range(HIDDEN)]
    hidden_now = [jnp.tanh(gain * d) * network.hidden_gain[h] for h, d in enumerate(drives)]
    outputs = [jnp.tanh(gain * neuron(w, hidden_now)) for w in network.w_output]
    return hidden_now, outputs
