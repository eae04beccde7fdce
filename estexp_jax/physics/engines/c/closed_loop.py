"""Closed loop on MuJoCo's C engine: any robot that MuJoCo simulates, all cores, next to nothing to compile.

Robots are lanes of one `mujoco.batch` a chunk, whose models differ by the effects that edit them; terms act between two
steps, as in open loop. Controllers respond for a whole chunk at once.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, final

import jax
import numpy as np

from estexp_jax.physics.effects.base import CommandLaw, Term
from estexp_jax.physics.effects.catalogue.part_lost import PartLost
from estexp_jax.physics.effects.changes import Values
from estexp_jax.physics.effects.elements import element_values
from estexp_jax.physics.engines.batching import cores
from estexp_jax.physics.engines.c.acting import ActingEffects, LaneHidden
from estexp_jax.physics.engines.c.distortions import distort_readings
from estexp_jax.physics.engines.c.edits import edited_models
from estexp_jax.physics.engines.c.stepping import LaneSteps
from estexp_jax.physics.engines.closed_loop import (
    BodyState,
    ClosedLoopSimulator,
    ReadingOverride,
    RobotInstance,
    Rollout,
)
from estexp_jax.physics.engines.open_loop_inputs import CommandSteps
from estexp_jax.physics.engines.open_loop_states import LaneBatchState
from estexp_jax.physics.model.travel import root_position_map
from estexp_jax.physics.model.validation import mujoco_warnings_suppressed

_FEWEST = 16
"""Robots that are not split over cores."""
_VECTOR = 8
"""Controllers respond for a multiple of so many robots and one filler, see `mjx.closed_loop`."""


def c_width(population: int) -> int:
    """A chunk for each core, and the filler."""
    return -(-max(_FEWEST, -(-population // cores())) // _VECTOR) * _VECTOR + 1


class _Chunk(NamedTuple):
    """Robots that are stepped together.

    Attributes:
        lanes: the robots.
        steps: of their physics.
        override: readings that controllers get; None: the robots' own.
    """

    lanes: RobotInstance
    steps: LaneSteps
    override: ReadingOverride | None


@final
@dataclass(frozen=True, eq=False)
class CClosedLoop(ClosedLoopSimulator):
    """Closed loops on the C engine."""

    def _rested(self, values: Values) -> dict[str, np.ndarray]:
        """See `ClosedLoopSimulator`; (robots, n_sites, variables) of each effect that has some."""
        n, home = len(next(iter(values.values()))), self.robot.home()
        with np.errstate(all="ignore"), mujoco_warnings_suppressed():
            models = edited_models(self.robot, self.catalogue, {}, [0] * n, values)
            acting = ActingEffects(self.robot, self.catalogue, models, values)
            speeds, on = np.zeros((n, self.robot.model.nv)), np.ones((n, self.robot.model.nactuator))
            ctrl = np.broadcast_to(self.interface.ctrl_centre, (n, self.interface.n_outputs))
            acting.begin(np.broadcast_to(home, (n, len(home))), speeds, ctrl, on, self._step_lengths(n))
            return self._by_site(acting, acting.rest(), n)

    def _run(self, lanes: RobotInstance, steps: int, *, active: bool, override: ReadingOverride | None) -> Rollout:
        n = len(lanes.weights)
        size = min(self.width - 1, max(_FEWEST, -(-n // cores())))
        parts = [np.arange(first, min(first + size, n)) for first in range(0, n, size)]
        taken = [jax.tree.map(lambda x, part=part: np.asarray(x)[part], (lanes, override)) for part in parts]
        with mujoco_warnings_suppressed(), ThreadPoolExecutor(min(cores(), len(parts))) as threads:
            found = list(threads.map(lambda part: self._chunk(part[0], part[1], steps, active), taken))
        return jax.tree.map(lambda *each: np.concatenate(each), *found)

    def _chunk(self, lanes: RobotInstance, override: ReadingOverride | None, steps: int, active: bool) -> Rollout:
        with np.errstate(all="ignore"):  # what a damage blows up is NaN, and no warning
            n = len(lanes.weights)
            models = edited_models(self.robot, self.catalogue, {}, [0] * n, lanes.values)
            acting = ActingEffects(self.robot, self.catalogue, models, lanes.values)
            chunk = _Chunk(lanes, LaneSteps(models, acting), override)
            return self._driven(chunk, steps, active)

    def _driven(self, chunk: _Chunk, steps: int, active: bool) -> Rollout:
        face, lanes, n = self.interface, chunk.lanes, len(chunk.lanes.weights)
        start, acting = lanes.start, chunk.steps.acting
        activation, hidden = np.zeros((n, self.robot.model.na)), _of_instances(acting, start.hidden)
        state = LaneBatchState(start.qpos, start.qvel, activation, start.warmstart, hidden)
        decode, respond = self._controllers
        filled = np.arange(self.width) % n  # so that a robot moves the same whatever the chunk's size
        parameters = decode(*jax.tree.map(lambda x: np.asarray(x)[filled], (lanes.values, lanes.weights)))
        neurons = np.zeros((self.width, self.policy.n_hidden), np.float32)
        shape = (n, self.rows)
        readings, commands = np.zeros((*shape, face.n_inputs)), np.zeros((*shape, face.n_outputs))
        place, sensed = np.zeros((*shape, self.robot.model.nq)), np.asarray(start.sensordata, float)
        lengths = np.broadcast_to(self._step_lengths(n), (self.substeps, n))
        on = np.ones((self.substeps, self.robot.model.nactuator, n))
        for row in range(steps):
            readings[:, row], place[:, row] = self._readings(lanes.values, state.qpos, sensed), state.qpos
            given = _overridden(chunk.override, row, readings[:, row])[filled]
            neurons, outputs = respond(parameters, neurons, given)
            commands[:, row] = np.asarray(outputs)[:n] if active else face.ctrl_centre
            ctrl = np.broadcast_to(commands[:, row].T, (self.substeps, face.n_outputs, n))
            state, found = chunk.steps.advance(state, CommandSteps(lengths, ctrl, on), ())
            sensed = found.sensors[-1].T
        matrix, offset = root_position_map(self.robot)
        after = self._by_site(acting, state.hidden, n)
        final = BodyState(state.qpos, state.qvel, state.warmstart, sensed, after)
        final.qpos[~chunk.steps.alive] = np.nan
        return Rollout(readings, commands, place @ matrix.T + offset, final, ~chunk.steps.alive)

    def _step_lengths(self, n: int) -> np.ndarray:
        return np.full(n, float(self.robot.model.opt.timestep))

    def _readings(self, values: Values, qpos: np.ndarray, sensed: np.ndarray) -> np.ndarray:
        """Readings (robots, n_inputs) as controllers get them: those of lost parts at rest, faults applied."""
        face = self.interface
        touch = np.where(sensed[:, face.columns] > 0.0, 1.0, -1.0)
        true = np.where(face.is_touch, touch, qpos[:, face.qpos])
        if PartLost.name in values:
            gone = np.clip(np.asarray(values[PartLost.name])[:, :, 0] @ face.lost, 0.0, 1.0)
            true = np.where(gone > 0.5, face.rest, true)
        whole = sensed.copy()
        whole[:, face.columns] = true
        whole = np.ascontiguousarray(whole.T)[None]
        distort_readings(self.robot, self.catalogue, values, whole)
        return whole[0, face.columns].T

    def _by_site(self, acting: ActingEffects, hidden: LaneHidden, n: int) -> dict[str, np.ndarray]:
        """Hidden variables (robots, elements, variables) of each effect, of those (variables, instances) at work."""
        found = {}
        for e in self.catalogue:
            if isinstance(e, Term | CommandLaw) and e.n_states:
                neutral = np.zeros((1, len(e.sites(self.robot)), len(e.parameters)))
                elements = element_values(e, self.robot, neutral).shape[1]
                found[e.name] = np.zeros((n, elements, e.n_states))
        for at in (*acting.laws, *acting.terms):
            if at.effect.n_states:
                found[at.effect.name][at.lane, at.site] = hidden[at.effect.name].T
        return found

    @cached_property
    def _controllers(self) -> tuple[Callable[..., Any], Callable[..., Any]]:
        """Parameters of robots' controllers, and their response to readings (robots, n_inputs)."""

        def respond(parameters: Any, neurons: Any, readings: Any) -> tuple[Any, Any]:
            after, outputs = self.policy.respond(parameters, neurons, self.interface.inputs(readings))
            return after, self.interface.commands(outputs)

        return jax.jit(jax.vmap(self.controller)), jax.jit(jax.vmap(respond))


def _overridden(override: ReadingOverride | None, row: int, own: np.ndarray) -> np.ndarray:
    """Readings (robots, n_inputs) that controllers get, of the robots' own; at factor 0 these do not matter."""
    if override is None:
        return own
    factor, added = override.factor[:, row], override.added[:, row]
    return np.where(factor == 0.0, added, factor * own + added)


def _of_instances(acting: ActingEffects, hidden: Mapping[str, np.ndarray]) -> LaneHidden:
    """Hidden variables (variables, instances) of effects at work, of those (robots, elements, variables)."""
    stateful = [e for e in (*acting.laws, *acting.terms) if e.effect.n_states]
    return {e.effect.name: np.ascontiguousarray(hidden[e.effect.name][e.lane, e.site].T) for e in stateful}
