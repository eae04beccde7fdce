"""Closed loop in lanes."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, final

import jax
import jax.numpy as jnp
import mujoco
import numpy as np

from estexp_jax.lanes.compilation import compile_lowered, lower
from estexp_jax.physics.effects.base import Distortion
from estexp_jax.physics.effects.catalogue.part_lost import PartLost
from estexp_jax.physics.effects.changes import Values
from estexp_jax.physics.engines.batching import cores, in_chunks
from estexp_jax.physics.engines.closed_loop import CompiledClosedLoop, ReadingOverride, RobotInstance, Rollout
from estexp_jax.physics.engines.devices import accelerated, wide
from estexp_jax.physics.engines.lanes.control_loop import ROWS, Batch, Block, ControlLoop, NetworkInputs
from estexp_jax.physics.engines.lanes.model import LanesModel, lanes_model

_VECTOR = 8
"""Robots in a chunk are a multiple of this, so that all take the same vector code and none depends on its place."""
_WIDEST = 104


def lanes_width(population: int) -> int:
    """Robots in a chunk: each core's share of half the population, in equal parts as large as stay in the cache.

    Equal, so that no core takes a last chunk while the others wait. Multiples of 32 are left out: arrays a power of two
    apart fall on the same lines of the cache. On an accelerator, half the population.
    """
    if accelerated():
        return wide(population, _VECTOR)
    share = -(-population // (2 * cores()))
    parts = -(-share // _WIDEST)
    width = -(-share // (parts * _VECTOR)) * _VECTOR
    return width + _VECTOR if width % 32 == 0 else width


@final
@dataclass(frozen=True, eq=False)
class LanesClosedLoop(CompiledClosedLoop):
    """Closed loops in lanes."""

    _lock: threading.Lock = field(default_factory=threading.Lock, init=False)
    _programs: dict[str, Any] = field(default_factory=dict, init=False)

    @cached_property
    def lanes(self) -> LanesModel:
        """The robot in lanes."""
        return lanes_model(self.on_mjx)

    @property
    def fast(self) -> bool:
        """Whether XLA compiled the program with the options that make it fast; after the first rollout."""
        return self._programs["fast"]

    @property
    def flops(self) -> float | None:
        """Floating-point operations of one robot in one control step, a lower bound; after the first rollout.

        XLA's count of the compiled program, with the body of each loop counted once: a control step with a single
        physics step, in which the solver takes a single Newton step. None where XLA gives no count.
        """
        counted = self._programs["advance"].cost_analysis().get("flops")
        return None if counted is None else float(counted) / self.width

    def _run(self, lanes: RobotInstance, steps: int, *, active: bool, override: ReadingOverride | None) -> Rollout:
        batch = jax.tree.map(np.asarray, (lanes, override))
        return in_chunks(lambda part: self._chunk(part[0], part[1], steps, active), batch, self.width)

    def _chunk(self, lanes: RobotInstance, override: ReadingOverride | None, steps: int, active: bool) -> Rollout:
        prepare, advance = self._compiled(lanes)
        batch, neurons, rows = prepare(lanes), np.zeros((self.policy.n_hidden, self.width), np.float32), []
        for done in range(0, steps, ROWS):
            inputs = NetworkInputs(*self._override(override, done), np.bool_(active))
            block = advance(batch, neurons, np.int32(min(ROWS, steps - done)), inputs)
            batch, neurons = batch._replace(start=block.final), block.neurons
            rows.append(block.rows)
        table = np.moveaxis(np.concatenate([np.asarray(r) for r in rows])[:steps], -1, 0)
        i, o = self.interface.n_inputs, self.interface.n_outputs
        final = jax.tree.map(lambda x: np.moveaxis(np.asarray(x), -1, 0), batch.start)
        sound = [np.all(np.abs(x) < mujoco.mjMAXVAL, axis=1) for x in (final.qpos, final.qvel)]  # false for NaN
        return Rollout(table[..., :i], table[..., i : i + o], table[..., i + o :], final, ~(sound[0] & sound[1]))

    def _override(self, override: ReadingOverride | None, done: int) -> ReadingOverride:
        """Reading overrides of one call, robots last; new arrays, as the call may still read them later."""
        shape = (ROWS, self.interface.n_inputs, self.width)
        tables = ReadingOverride(np.ones(shape, np.float32), np.zeros(shape, np.float32))
        for table, given in zip(tables, override or (), strict=False):
            part = np.moveaxis(given[:, done : done + ROWS], 0, -1)
            table[: len(part)] = part
        return tables

    def _compiled(self, lanes: RobotInstance) -> tuple[Any, Any]:
        """Both executables, compiled at the first call."""
        with self._lock:
            if not self._programs:
                prepare = lower(jax.vmap(self._prepared, out_axes=-1), lanes)
                neurons = np.zeros((self.policy.n_hidden, self.width), np.float32)
                inputs = NetworkInputs(*self._override(None, 0), np.bool_(True))
                with ThreadPoolExecutor(1) as other:
                    preparing = other.submit(prepare.compile)
                    advance = lower(self._advanced, prepare.out_info, neurons, np.int32(0), inputs)
                    self._programs["advance"], self._programs["fast"] = compile_lowered(advance, self.width)
                    self._programs["prepare"] = preparing.result()
        return self._programs["prepare"], self._programs["advance"]

    def _prepared(self, lane: RobotInstance) -> Batch:
        """Constants of one robot's rollout."""
        controller = self.policy.prepare_lanes(self.controller(lane.values, lane.weights))
        lost = jnp.zeros(self.interface.n_inputs, bool)
        if PartLost.name in lane.values:
            lost = lane.values[PartLost.name][:, 0] @ jnp.asarray(self.interface.lost, jnp.float32) > 0.5
        fields = self.lanes.fields(self.on_mjx.model, lane.values)
        return Batch(fields, lane.values, controller, lost, *self._faults(lane.values), lane.start)

    def _faults(self, values: Values) -> tuple[jax.Array, jax.Array]:
        """Scale and shift, (n_inputs,) each, that sensor faults apply to readings; all faults are of this kind."""

        def distorted(x: float) -> jax.Array:
            readings = jnp.full(self.robot.model.nsensordata, x, jnp.float32)
            for effect in self.catalogue:
                if isinstance(effect, Distortion):
                    readings = effect.distort(self.robot, readings, values[effect.name])
            return readings[self.interface.columns]

        shift = distorted(0.0)
        return distorted(1.0) - shift, shift

    def _advanced(self, batch: Batch, neurons: Any, steps: Any, inputs: NetworkInputs) -> Block:
        """All robots, some control steps later."""
        return ControlLoop(self, self.lanes, batch).advance(neurons, steps, inputs)
