"""Open loop, whatever the engine: recorded commands replayed through many hypothetical robots at once.

A lane is one hypothesis on one segment of a recording. All lanes, whatever their hypothesis, length and clock, share
one executable: it advances a fixed block of physics steps, and is called until the longest segment ends.
"""

from __future__ import annotations

import abc
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import jax
import mujoco
import numpy as np
from mujoco import mjx

from estexp_jax.errors import InputError
from estexp_jax.physics.command_schedule import CommandHistory
from estexp_jax.physics.effects.base import CommandLaw, Term
from estexp_jax.physics.effects.changes import Values
from estexp_jax.physics.effects.registry import Catalogue
from estexp_jax.physics.engines.batching import EngineChoice, cores
from estexp_jax.physics.engines.mjx.model import MjxModel, fields_of, mjx_model
from estexp_jax.physics.engines.mjx.terms import Hidden, stateful
from estexp_jax.physics.engines.open_loop_inputs import (
    CommandSteps,
    RolledRows,
    add_drift,
    command_routes,
    command_steps,
    delay_readings,
    equal_commands,
    initial_states,
    instances_with,
    rolled_rows,
)
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.window import Window

_ROLL = 256
"""Rows in one call that hidden variables are rolled along."""
Controller = Callable[[float, np.ndarray, np.ndarray], np.ndarray]
"""(time in s, qpos (nq,), qvel (nv,)) of a row -> commands (nu,), held until the next one."""
_Array = Any
"""A NumPy array outside the compiled function, a JAX array inside."""


class LaneBatchState(NamedTuple):
    """Lanes between two blocks: arrays (lanes, ...), and hidden variables as an engine keeps them."""

    qpos: _Array
    qvel: _Array
    act: _Array
    warmstart: _Array
    sensordata: _Array  # of the step before
    hidden: Hidden


class StepReadings(NamedTuple):
    """What lanes showed at the beginning of steps, (steps, ..., lanes)."""

    sensors: np.ndarray
    qpos: np.ndarray
    qvel: np.ndarray


class OpenLoopRollout(NamedTuple):
    """What lanes did at the rows of their segments, NaN beyond a segment's end.

    Attributes:
        sensors: (lanes, rows, nsensordata) readings, faults applied.
        qpos: (lanes, rows, nq).
        qvel: (lanes, rows, nv).
    """

    sensors: np.ndarray
    qpos: np.ndarray
    qvel: np.ndarray


class PerRecordingModel(NamedTuple):
    """What recordings' known settings make different from recording to recording.

    Attributes:
        positions: among the leaves of the MJX model.
        values: for each of them, (recordings, ...).
        fields: names of those that are fields of numbers.
    """

    positions: tuple[int, ...]
    values: tuple[np.ndarray, ...]
    fields: frozenset[str]


@dataclass(frozen=True, eq=False)
class OpenLoopSimulator(abc.ABC):
    """Replays recordings through hypotheses about a robot.

    Attributes:
        on_mjx: the nominal robot and the catalogue of effects.
        differing: what differs from recording to recording.
        width: lanes in a chunk.
        block: physics steps in a call.
        choice: which engine it is, and why.
    """

    on_mjx: MjxModel
    differing: PerRecordingModel
    width: int
    block: int
    choice: EngineChoice

    @abc.abstractmethod
    def _prepared(self, values: Values, overrides: tuple) -> Any:
        """What does not change from block to block; `overrides` are the lanes' `per_recording_model`."""

    @abc.abstractmethod
    def _rested(self, prepared: Any, roll: RolledRows) -> Hidden:
        """Hidden variables of robots that have been where they are, a row of a roll, for long."""

    @abc.abstractmethod
    def _rolled(self, prepared: Any, hidden: Hidden, roll: RolledRows) -> Hidden:
        """Hidden variables after the rows of a roll, along which robots moved as recorded."""

    @abc.abstractmethod
    def _advanced(
        self, prepared: Any, state: LaneBatchState, drive: CommandSteps
    ) -> tuple[LaneBatchState, StepReadings]:
        """Whole blocks of steps: the state after them, and what was seen at the beginning of each."""

    @property
    def robot(self) -> Robot:
        """The nominal robot."""
        return self.on_mjx.robot

    @property
    def catalogue(self) -> Catalogue:
        """The effects that values have an entry for."""
        return self.on_mjx.catalogue

    def model(self, values: Values, overrides: tuple) -> mjx.Model:
        """One lane's model: with its recording's settings, and its edits."""
        leaves, tree = jax.tree.flatten(self.on_mjx.model)
        for position, leaf in zip(self.differing.positions, overrides, strict=True):
            leaves[position] = leaf
        return self.on_mjx.edited(jax.tree.unflatten(tree, leaves), values)

    def replay(self, values: Values, segments: Sequence[Window], which: np.ndarray) -> OpenLoopRollout:
        """Replay lanes.

        Args:
            values: (lanes, n_sites, n_parameters) for each effect.
            segments: what can be replayed.
            which: (lanes,) index of each lane's segment.
        """
        which = np.asarray(which)
        remembers = instances_with(self.robot, stateful(self.catalogue), values)
        order = np.lexsort([which, self._at_work(values, which), [segments[w].steps.n_steps for w in which]])
        chunks = [order[i : i + self.width] for i in range(0, len(order), self.width)]

        def run(lanes: np.ndarray) -> OpenLoopRollout:
            chosen = np.resize(lanes, self.width)  # the last chunk repeats its lanes
            part = {name: np.asarray(v, np.float32)[chosen] for name, v in values.items()}
            here = [segments[w] for w in which[chosen]]
            return self._chunk(part, here, len(lanes), remembers=bool(remembers[lanes].any()))

        with ThreadPoolExecutor(cores()) as threads:
            parts = list(threads.map(run, chunks))
        rows = max(segments[w].rows for w in which)
        return OpenLoopRollout(*(self._gather(parts, chunks, field, rows) for field in OpenLoopRollout._fields))

    def _gather(self, parts: list[OpenLoopRollout], chunks: list[np.ndarray], field: str, rows: int) -> np.ndarray:
        whole = np.full((sum(map(len, chunks)), rows, getattr(parts[0], field).shape[2]), np.nan, np.float32)
        for part, lanes in zip(parts, chunks, strict=True):
            found = getattr(part, field)
            whole[lanes, : found.shape[1]] = found
        return whole

    def _chunk(self, values: Values, segments: list[Window], n: int, *, remembers: bool) -> OpenLoopRollout:
        """Replay a chunk's lanes, keep the first `n`; if none remembers, what came before the start does not matter."""
        n_steps = max(s.steps.n_steps for s in segments) + 2  # one before for the forces, one more to read the last row
        blocks = -(-n_steps // self.block)
        drive = command_steps(self.robot, self.catalogue, values, segments, blocks * self.block)
        prepared, state = self._started(values, segments, remembers=remembers)
        _, seen = self._advanced(prepared, state, drive)
        return self._shown(StepReadings(*(x[1:] for x in seen)), values, segments, n)

    def steered(self, values: Values, stretch: Window, controller: Controller) -> tuple[OpenLoopRollout, np.ndarray]:
        """Replay one lane from its start under a controller's commands instead of recorded ones; for a `width` of 1.

        Args:
            values: (1, n_sites, n_parameters) for each effect.
            stretch: from its recording's first row on, each row of at most `block` steps; its commands do not count.
            controller: gives each row's commands.

        Returns:
            What the robot did, and its commands (rows, nu).
        """
        values = {name: np.asarray(v, np.float32) for name, v in values.items()}
        prepared, state = self._started(values, [stretch], remembers=False)
        steps, time, nothing = stretch.steps, stretch.history.time, np.zeros(self.block)
        late, source = command_routes(self.robot, self.catalogue, values)
        rows: list[np.ndarray] = []
        seen: list[StepReadings] = []
        for row in range(stretch.rows):
            rows.append(np.asarray(controller(float(time[row]), *(np.asarray(x[0], float) for x in state[:2])), float))
            own = slice(*steps.sample[row : row + 2]) if row + 1 < stretch.rows else slice(0, 0)
            count = own.stop - own.start
            length, start = nothing.copy(), np.full(self.block, time[row])
            length[:count], start[:count] = steps.length[own], steps.start[own]
            ctrl = CommandHistory(time[: row + 1], np.array(rows)).mean(start, length, late[0], source[0])
            enable = np.tile(stretch.enable[row], (self.block, 1))
            drive = CommandSteps(*(np.asarray(x, np.float32)[..., None] for x in (length, ctrl, enable)))
            if row == 0:  # what sensors of forces show in the first row
                state, _ = self._advanced(prepared, state, drive._replace(length=np.zeros_like(drive.length)))
            state, part = self._advanced(prepared, state, drive)
            seen.append(StepReadings(*(x[: max(count, 1)] for x in part)))
        commands = np.array(rows)
        whole = StepReadings(*(np.concatenate(kind) for kind in zip(*seen, strict=True)))
        told = replace(stretch, history=stretch.history.told(commands))
        return self._shown(whole, values, [told], 1), commands

    def _started(self, values: Values, segments: list[Window], *, remembers: bool) -> tuple[Any, LaneBatchState]:
        """What does not change from block to block, and the state that lanes start from."""
        model, template = self.robot.model, self.on_mjx.data
        recording = [s.recording for s in segments]
        prepared = self._prepared(values, tuple(o[recording] for o in self.differing.values))
        state = LaneBatchState(
            *initial_states(self.robot, self.catalogue, values, segments),
            np.zeros((len(segments), model.na), np.float32),
            np.zeros((len(segments), model.nv), np.float32),
            np.broadcast_to(np.asarray(template.sensordata), (len(segments), model.nsensordata)),
            {},
        )
        if stateful(self.catalogue):
            state = state._replace(hidden=self._hidden(prepared, values, segments, remembers=remembers))
        return prepared, state

    def _shown(self, seen: StepReadings, values: Values, segments: list[Window], n: int) -> OpenLoopRollout:
        """What the first `n` lanes show at their rows, of all steps: late and adrift as sensors are."""
        delay_readings(self.robot, self.catalogue, seen.sensors, values, segments)
        add_drift(self.robot, self.catalogue, seen.sensors, values, segments)
        rows = max(s.rows for s in segments[:n])
        return OpenLoopRollout(*(_rows(x, segments[:n], rows) for x in seen))

    def _hidden(self, prepared: Any, values: Values, segments: list[Window], *, remembers: bool) -> Hidden:
        """Hidden variables at the lanes' starts: rolled along each recording's rows before them."""
        n_rows = max(s.first if s.path is not None else 0 for s in segments) if remembers else 0
        blocks = -(-n_rows // _ROLL)
        before = rolled_rows(self.robot, self.catalogue, values, segments, blocks * _ROLL)
        hidden = self._rested(prepared, RolledRows(*(x[0] for x in before)))
        for b in range(blocks):
            hidden = self._rolled(prepared, hidden, RolledRows(*(x[b * _ROLL : (b + 1) * _ROLL] for x in before)))
        return hidden

    def _at_work(self, values: Values, which: np.ndarray) -> np.ndarray:
        """Numbers (lanes,), alike for lanes that have the same terms and command laws at work."""
        acting = [e for e in self.catalogue if isinstance(e, Term | CommandLaw)]
        each = np.array([np.zeros(len(which), bool), *(instances_with(self.robot, [e], values) for e in acting)])
        return np.unique(each, axis=1, return_inverse=True)[1]


def _rows(x: np.ndarray, segments: Sequence[Window], rows: int) -> np.ndarray:
    """Columns (lanes, rows, columns) at the rows of segments, of those (steps, columns, lanes) at all steps."""
    found = np.full((len(segments), rows, x.shape[1]), np.nan, np.float32)
    for i, there in equal_commands(segments, np.ones(len(segments), bool)):
        sample = segments[i].steps.sample
        found[there, : len(sample)] = np.moveaxis(x[sample, :, there], -1, 0)
    return found


def per_recording_model(nominal: MjxModel, per_recording: Sequence[Robot]) -> PerRecordingModel:
    """What the known settings of recordings change in a model.

    Raises:
        InputError: they change the model's structure.
    """
    leaves, tree = jax.tree.flatten(nominal.model)
    distinct = {id(r): r for r in per_recording}
    variants = {k: jax.tree.flatten(mjx_model(r, nominal.catalogue).model) for k, r in distinct.items()}
    if any(other != tree for _, other in variants.values()):
        raise InputError("a recording's settings change what the model consists of", where=nominal.robot.source)
    each = [variants[id(r)][0] for r in per_recording]
    positions = tuple(i for i, leaf in enumerate(leaves) if any(not np.array_equal(leaf, own[i]) for own in each))
    names = {id(leaf): name for name, leaf in fields_of(nominal.model).items()}
    fields = frozenset(names[id(leaves[i])] for i in positions if id(leaves[i]) in names)
    return PerRecordingModel(
        positions, tuple(np.stack([np.asarray(own[i]) for own in each]) for i in positions), fields
    )


def is_acceleration(robot: Robot) -> np.ndarray:
    """Which values of `sensordata` (nsensordata,) show forces or accelerations: of the step before."""
    acceleration = robot.model.sensor_needstage == int(mujoco.mjtStage.mjSTAGE_ACC)
    return np.repeat(acceleration, robot.model.sensor_dim)
