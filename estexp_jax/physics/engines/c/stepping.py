"""Steps of a chunk's lanes in MuJoCo's batch: each lane with its own length, commands, and what acts on it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, final

import mujoco
import numpy as np

from estexp_jax.physics.engines.c.acting import ActingEffects, LaneHidden
from estexp_jax.physics.engines.c.batches import refusals
from estexp_jax.physics.engines.c.lane_models import LaneModels
from estexp_jax.physics.engines.c.motor_scales import MotorScales
from estexp_jax.physics.engines.open_loop_inputs import CommandSteps
from estexp_jax.physics.engines.open_loop_states import LaneBatchState, StepReadings
from estexp_jax.physics.model.validation import BLOWN_UP

_PER_STEP = {"damping": "dof_damping", "friction": "dof_frictionloss"}
"""Fields of the model to which parts of the step's table are added."""
_STATE = ("qpos", "qvel", "act", "qacc_warmstart")


class ShownVariable(NamedTuple):
    """A hidden variable of an effect that a sensor shows: added, times `factor`, to a column at lanes."""

    effect: str
    state: int
    instances: np.ndarray
    lanes: np.ndarray
    column: int
    factor: float


@final
class LaneSteps:
    """The lanes of a chunk while they are stepped; lanes that blow up are left out from then on, and read NaN."""

    def __init__(self, models: LaneModels, acting: ActingEffects) -> None:
        """With edited models."""
        self._models, self.acting, self._batch = models, acting, models.batch
        self._model: mujoco.MjModel = models.batch.model
        names = (*_STATE, "ctrl", "qfrc_applied", "xfrc_applied", "sensordata")
        self._data = {name: models.batch.bind(name) for name in names}
        self._place = models.batch.bind("xipos") if acting.body_forces else None
        self._motors = MotorScales(models)
        fields = (*_PER_STEP.values(), "dof_armature", "dof_M0")
        self._own = {name: np.array(models.read(name)) for name in fields}
        self._alive, self._varies = ~models.failed, models.batch.expanded("opt.timestep") is not None

    @property
    def alive(self) -> np.ndarray:
        """Lanes (lanes,) that have not blown up."""
        return self._alive

    def advance(
        self, state: LaneBatchState, drive: CommandSteps, displayed: Sequence[ShownVariable]
    ) -> tuple[LaneBatchState, StepReadings]:
        """Take steps; the state after them, and readings and states at the beginning of each.

        Args:
            state: at the beginning.
            drive: the steps.
            displayed: hidden variables that sensors show.
        """
        for name, x in zip(_STATE, state[:-1], strict=True):
            self._data[name][:] = x
        self._alive &= np.isfinite(state.qpos).all(axis=1) & np.isfinite(state.qvel).all(axis=1)
        n, lanes, hidden = len(drive.length), self._models.lanes, state.hidden
        sensed = np.array(self._data["sensordata"])
        found = StepReadings(*(np.empty((n, x.shape[1], lanes)) for x in (sensed, state.qpos, state.qvel)))
        moved = np.ones(lanes, bool)
        for k in range(n):
            broken = ~self._alive
            found.qpos[k], found.qvel[k] = self._data["qpos"].T, self._data["qvel"].T
            moves = drive.length[k] > 0.0
            if (moves | moved).any():  # else all have come to their ends, and were read there
                after = self._step(CommandSteps(*(x[k] for x in drive)), moves, moved, hidden)
                sensed = np.array(self._data["sensordata"])
                for s in displayed:
                    sensed[s.lanes, s.column] += s.factor * after[s.effect][s.state, s.instances]
                hidden = self.acting.kept(moves, hidden, after)
            found.sensors[k], moved = sensed.T, moves
            for x in found:
                x[k][:, broken] = np.nan
        qpos, qvel, act, warmstart = (np.array(self._data[name]) for name in _STATE)
        return LaneBatchState(qpos, qvel, act, warmstart, hidden), found

    def _step(self, now: CommandSteps, moves: np.ndarray, reads: np.ndarray, hidden: LaneHidden) -> LaneHidden:
        """Step lanes that move, compute readings of others that `reads`; hidden variables after the step."""
        nominal = float(self._model.opt.timestep)
        length = np.where(moves, now.length, nominal)
        if self._varies or (length != nominal).any():
            self._models.own("opt.timestep")[:], self._varies = length, True
        after = self._act(now.ctrl.T, now.enable.T, length, hidden)
        stepped, read = np.flatnonzero(moves & self._alive), np.flatnonzero(~moves & reads & self._alive)
        if read.size:
            warmstart = self._data["qacc_warmstart"][read].copy()
            self._call(self._batch.forward, read)
            self._data["qacc_warmstart"][read] = warmstart
        if stepped.size:
            self._call(self._batch.step, stepped)
        self._alive &= ~self._batch.warning[:, BLOWN_UP, 1].any(axis=1)
        return after

    def _call(self, what: Callable[..., None], lanes: np.ndarray, **kwargs: Any) -> None:
        """Let MuJoCo do something for lanes; those in which it fails are left out from then on."""
        try:
            what(None if len(lanes) == self._models.lanes else lanes, **kwargs)
        except refusals() as error:
            self._alive[error.ids] = False

    def _act(self, ctrl: np.ndarray, enable: np.ndarray, length: np.ndarray, hidden: LaneHidden) -> LaneHidden:
        """Give the batch a step's inputs, after all that acts on them; hidden variables after the step."""
        data, acting, own = self._data, self.acting, self._models.own
        if not (acting.laws or acting.terms):
            data["ctrl"][:] = ctrl
            self._motors.write(acting.switches(enable), None)
            self._pull()
            return {}
        table = acting.begin(data["qpos"], data["qvel"], ctrl, enable, length)
        after, written = acting.act(hidden), acting.written
        data["ctrl"][:], data["qfrc_applied"][:] = table["ctrl"], table["force"]
        for part in written & set(_PER_STEP):
            name = _PER_STEP[part]
            own(name)[:] = self._own[name] + table[part]
        if "rotor_inertia" in written:
            own("dof_armature")[:] = table["rotor_inertia"]
            added, simple = table["rotor_inertia"] - self._own["dof_armature"], self._model.dof_simplenum > 0
            if simple.any():  # whose mass matrix MuJoCo takes as it was at the home position
                own("dof_M0")[:] = self._own["dof_M0"] + added * simple
        self._motors.write(table["on"], table["share"])
        self._pull()
        return after

    def _pull(self) -> None:
        """Apply body forces where bodies are now."""
        if self._place is None:
            return
        lanes = np.unique(np.concatenate([e.lane for e in self.acting.body_forces]))
        self._call(self._batch.forward, lanes[self._alive[lanes]], stage=mujoco.mjtStage.mjSTAGE_POS)
        pull = self._data["xfrc_applied"]
        pull[:] = 0.0
        for e in self.acting.body_forces:
            e.act(self._place, pull)
