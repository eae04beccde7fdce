"""Open loop on MJX: recorded commands replayed through many hypothetical robots at once.

A lane is one hypothesis on one segment of a recording. All lanes, whatever their hypothesis, length and clock, share
one executable: it advances a fixed block of physics steps, and is called until the longest segment ends.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple, final

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from mujoco import mjx

from estexp_jax.errors import InputError
from estexp_jax.physics.changes import Values
from estexp_jax.physics.effects.base import Distortion
from estexp_jax.physics.engines.batching import cores
from estexp_jax.physics.engines.mjx_model import MjxModel, mjx_model, stepped, switched
from estexp_jax.physics.engines.mjx_terms import Hidden, Now, stateful
from estexp_jax.physics.engines.replay_inputs import Drive, Roll, drive_of, read_late, rolls, starts
from estexp_jax.physics.registry import Catalogue
from estexp_jax.physics.robot import Robot
from estexp_jax.physics.segment import Segment

_ROLL = 256
"""Rows in one call that hidden variables are rolled along."""
_Array = Any
"""A NumPy array outside the compiled function, a JAX array inside."""


class _State(NamedTuple):
    qpos: _Array
    qvel: _Array
    act: _Array
    warmstart: _Array
    sensordata: _Array  # of the step before
    hidden: Hidden


class Replay(NamedTuple):
    """What lanes did at the rows of their segments, NaN beyond a segment's end.

    Attributes:
        sensors: (lanes, rows, nsensordata) readings, faults applied.
        qpos: (lanes, rows, nq).
        qvel: (lanes, rows, nv).
    """

    sensors: np.ndarray
    qpos: np.ndarray
    qvel: np.ndarray


@final
@dataclass(frozen=True, eq=False)
class Replayer:
    """Replays recordings through hypotheses about a robot.

    Attributes:
        on_mjx: the nominal robot and the catalogue of effects.
        differing: positions of the model's leaves in which recordings differ.
        overrides: for each of them, (recordings, ...) what each recording has there.
        width: lanes in a chunk.
        block: physics steps in a call.
    """

    on_mjx: MjxModel
    differing: tuple[int, ...]
    overrides: tuple[np.ndarray, ...]
    width: int
    block: int

    @property
    def robot(self) -> Robot:
        """The nominal robot."""
        return self.on_mjx.robot

    @property
    def catalogue(self) -> Catalogue:
        """The effects that values have an entry for."""
        return self.on_mjx.catalogue

    def replay(self, values: Values, segments: Sequence[Segment], which: np.ndarray) -> Replay:
        """Replay lanes.

        Args:
            values: (lanes, n_sites, n_parameters) for each effect.
            segments: what can be replayed.
            which: (lanes,) index of each lane's segment.
        """
        which = np.asarray(which)
        order = np.argsort([segments[w].steps.n_steps for w in which], kind="stable")
        chunks = [order[i : i + self.width] for i in range(0, len(order), self.width)]

        def run(lanes: np.ndarray) -> Replay:
            chosen = np.resize(lanes, self.width)  # the last chunk repeats its lanes
            part = {name: np.asarray(v, np.float32)[chosen] for name, v in values.items()}
            return self._chunk(part, [segments[w] for w in which[chosen]], len(lanes))

        with ThreadPoolExecutor(cores()) as threads:
            parts = list(threads.map(run, chunks))
        rows = max(segments[w].rows for w in which)
        return Replay(*(self._gather(parts, chunks, field, rows) for field in Replay._fields))

    def _gather(self, parts: list[Replay], chunks: list[np.ndarray], field: str, rows: int) -> np.ndarray:
        whole = np.full((sum(map(len, chunks)), rows, getattr(parts[0], field).shape[2]), np.nan, np.float32)
        for part, lanes in zip(parts, chunks, strict=True):
            found = getattr(part, field)
            whole[lanes, : found.shape[1]] = found
        return whole

    def _chunk(self, values: Values, segments: list[Segment], n: int) -> Replay:
        """Replay `width` lanes, keep the first `n`."""
        model, template = self.robot.model, self.on_mjx.data
        n_steps = max(s.steps.n_steps for s in segments) + 1  # one more, to read the last row
        blocks = -(-n_steps // self.block)
        drive = drive_of(self.robot, self.catalogue, values, segments, blocks * self.block)
        recording = [s.recording for s in segments]
        overrides = tuple(o[recording] for o in self.overrides)
        state = _State(
            *starts(self.robot, self.catalogue, values, segments),
            np.zeros((len(segments), model.na), np.float32),
            np.zeros((len(segments), model.nv), np.float32),
            np.broadcast_to(np.asarray(template.sensordata), (len(segments), model.nsensordata)),
            {},
        )
        if stateful(self.catalogue):
            state = state._replace(hidden=self._hidden(values, overrides, segments))
        seen = []
        for b in range(blocks):
            part = jax.tree.map(lambda x, b=b: x[:, b * self.block : (b + 1) * self.block], drive)
            state, out = _block(self, values, overrides, state, part)
            seen.append(jax.tree.map(np.asarray, out))
        whole = [np.concatenate([part[i] for part in seen], axis=1) for i in range(3)]
        read_late(self.robot, self.catalogue, whole[0], values, segments)
        rows = max(s.rows for s in segments[:n])
        return Replay(
            *(np.stack([_rows(x[i], s.steps.sample, rows) for i, s in enumerate(segments[:n])]) for x in whole)
        )

    def _hidden(self, values: Values, overrides: tuple, segments: list[Segment]) -> Hidden:
        """Hidden variables (lanes, n_sites) at the lanes' starts: rolled along each recording's rows before them."""
        n_rows = max(s.first if s.path is not None else 0 for s in segments)
        blocks = -(-n_rows // _ROLL)
        before = rolls(self.robot, self.catalogue, values, segments, blocks * _ROLL)
        hidden = _rested(self, values, overrides, jax.tree.map(lambda x: x[:, 0], before))
        for b in range(blocks):
            part = jax.tree.map(lambda x, b=b: x[:, b * _ROLL : (b + 1) * _ROLL], before)
            hidden = _rolled(self, values, overrides, hidden, part)
        return hidden


def _rows(x: np.ndarray, sample: np.ndarray, rows: int) -> np.ndarray:
    found = np.full((rows, x.shape[1]), np.nan, np.float32)
    found[: len(sample)] = x[sample]
    return found


def replayer(
    robot: Robot, catalogue: Catalogue, per_recording: Sequence[Robot], *, width: int = 64, block: int = 256
) -> Replayer:
    """A replayer for recordings of a robot.

    Args:
        robot: the nominal robot.
        catalogue: the effects that hypotheses draw on.
        per_recording: the nominal robot with each recording's known settings.
        width: lanes in a chunk.
        block: physics steps in a call.

    Raises:
        InputError: MJX cannot simulate the model, or a recording's settings change the model's structure.
    """
    nominal = mjx_model(robot, catalogue)
    leaves, tree = jax.tree.flatten(nominal.model)
    distinct = {id(r): r for r in per_recording}
    variants = {k: jax.tree.flatten(mjx_model(r, catalogue).model) for k, r in distinct.items()}
    if any(other != tree for _, other in variants.values()):
        raise InputError("a recording's settings change what the model consists of", where=robot.source)
    each = [variants[id(r)][0] for r in per_recording]
    differing = tuple(i for i, leaf in enumerate(leaves) if any(not np.array_equal(leaf, own[i]) for own in each))
    overrides = tuple(np.stack([np.asarray(own[i]) for own in each]) for i in differing)
    return Replayer(nominal, differing, overrides, width, block)


@partial(jax.jit, static_argnums=0)
def _block(self: Replayer, values: Values, overrides: tuple, state: _State, drive: Drive) -> Any:
    return jax.vmap(partial(_block_one, self))(values, overrides, state, drive)


def _model(self: Replayer, values: Values, overrides: tuple) -> mjx.Model:
    """One lane's model: with its recording's settings, and its edits."""
    leaves, tree = jax.tree.flatten(self.on_mjx.model)
    for position, leaf in zip(self.differing, overrides, strict=True):
        leaves[position] = leaf
    return self.on_mjx.edited(jax.tree.unflatten(tree, leaves), values)


def _block_one(self: Replayer, values: Values, overrides: tuple, state: _State, drive: Drive) -> Any:
    """One lane's block: its state after it, and (sensors, qpos, qvel) at the beginning of each step."""
    model = _model(self, values, overrides)
    # Position and velocity sensors read the state a step begins with; force and acceleration sensors what acted before.
    before = jnp.asarray(np.repeat(_is_acceleration(self.robot), self.robot.model.sensor_dim))

    def step(state: _State, now: Drive):  # noqa: ANN202
        data, hidden = _step(self, model, values, state, now)
        sensors: Any = jnp.where(before, state.sensordata, data.sensordata)
        for effect in self.catalogue:
            if isinstance(effect, Distortion):
                sensors = effect.distort(self.robot, sensors, values[effect.name])
        after = _State(data.qpos, data.qvel, data.act, data.qacc_warmstart, data.sensordata, hidden)
        return after, (sensors, state.qpos, state.qvel)

    return jax.lax.scan(step, state, drive)


def _is_acceleration(robot: Robot) -> np.ndarray:
    return robot.model.sensor_needstage == int(mujoco.mjtStage.mjSTAGE_ACC)


def _step(self: Replayer, model: mjx.Model, values: Values, state: _State, drive: Drive) -> tuple[mjx.Data, Hidden]:
    model = switched(model.replace(opt=model.opt.replace(timestep=drive.length)), drive.enable)
    now = Now(state.qpos, state.qvel, drive.ctrl, drive.enable, drive.length)
    does = self.on_mjx.acted(model, values, state.hidden, now)
    data = self.on_mjx.data.replace(qpos=state.qpos, qvel=state.qvel, act=state.act, qacc_warmstart=state.warmstart)
    return stepped(does, data), does.hidden


@partial(jax.jit, static_argnums=0)
def _rested(self: Replayer, values: Values, overrides: tuple, roll: Roll) -> Hidden:
    def one(values: Values, overrides: tuple, roll: Roll) -> Hidden:
        return self.on_mjx.rested(_model(self, values, overrides), values, Now(*roll))

    return jax.vmap(one)(values, overrides, roll)


@partial(jax.jit, static_argnums=0)
def _rolled(self: Replayer, values: Values, overrides: tuple, hidden: Hidden, roll: Roll) -> Hidden:
    """Hidden variables after the rows of a roll, along which the robot moved as recorded."""

    def one(values: Values, overrides: tuple, hidden: Hidden, roll: Roll) -> Hidden:
        model = _model(self, values, overrides)

        def step(hidden: Hidden, now: Roll) -> tuple[Hidden, None]:
            switched_model = switched(model, now.enable)
            after = self.on_mjx.acted(switched_model, values, hidden, Now(*now)).hidden
            return jax.tree.map(partial(jnp.where, now.length > 0.0), after, hidden), None

        return jax.lax.scan(step, hidden, roll)[0]

    return jax.vmap(one)(values, overrides, hidden, roll)
