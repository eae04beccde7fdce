"""Open loop on MuJoCo's C engine: any robot that MuJoCo simulates, with nothing to compile but effects at work.

The robot is the user's model as it is, with its own solver. Lanes are simulations of one `mujoco.batch` a chunk, whose
models differ in the fields that settings and edits change; terms act on them between two steps.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, NamedTuple, final

import numpy as np

from estexp_jax.physics.effects.changes import Values
from estexp_jax.physics.engines.batching import cores
from estexp_jax.physics.engines.c.acting import ActingEffects, LaneHidden
from estexp_jax.physics.engines.c.distortions import distort_readings
from estexp_jax.physics.engines.c.edits import edited_models
from estexp_jax.physics.engines.c.histories import filled_histories
from estexp_jax.physics.engines.c.stepping import LaneSteps, ShownVariable
from estexp_jax.physics.engines.motor_readings import motor_readings
from estexp_jax.physics.engines.open_loop import OpenLoopRollout, OpenLoopSimulator, RowController
from estexp_jax.physics.engines.open_loop_inputs import CommandSteps, RolledRows, command_routes
from estexp_jax.physics.engines.open_loop_states import LaneBatchState, StepReadings
from estexp_jax.physics.model.validation import mujoco_warnings_suppressed
from estexp_jax.physics.window import Window

C_REPLAY = 512, 1
"""Most lanes in a chunk, and physics steps that its length is a multiple of."""
_FEWEST = 32
"""Lanes that are not split over cores."""
_NUMBERS = 2**24
"""Most numbers that the commands and readings of a chunk hold, which bounds its lanes."""


class _Prepared(NamedTuple):
    values: Values
    steps: LaneSteps
    displayed: list[ShownVariable]


@final
@dataclass(frozen=True, eq=False)
class COpenLoop(OpenLoopSimulator):
    """Open loops on the C engine.

    Attributes:
        recorded: fields (recordings, ...) of the model in which recordings differ.
    """

    recorded: dict[str, np.ndarray]

    dtype: ClassVar[type[np.floating]] = np.float64

    def replay(self, values: Values, windows: Sequence[Window], which: np.ndarray) -> OpenLoopRollout:
        """See `OpenLoopSimulator`; lanes that blow up are NaN from then on, and MuJoCo does not warn of them."""
        with mujoco_warnings_suppressed():
            return super().replay(values, windows, which)

    def steered(self, values: Values, window: Window, controller: RowController) -> tuple[OpenLoopRollout, np.ndarray]:
        """See `OpenLoopSimulator`."""
        with mujoco_warnings_suppressed():
            return super().steered(values, window, controller)

    def _chunk_size(self, n: int, n_steps: int) -> int:
        model = self.robot.model
        width = n_steps * (model.nsensordata + model.nq + model.nv + model.nu + model.nactuator + 1)
        most = max(1, min(self.width, _NUMBERS // width))
        return min(most, max(_FEWEST, -(-n // cores())))

    def _filled_up(self, lanes: np.ndarray) -> np.ndarray:
        return lanes

    def _prepared(self, values: Values, windows: Sequence[Window]) -> _Prepared:
        recording = [s.recording for s in windows]
        with np.errstate(all="ignore"):  # what a hypothesis blows up is NaN, and no warning
            finer = self._is_finer(windows)
            models = edited_models(self.robot, self.catalogue, self.recorded, recording, values, finer=finer)
            acting = ActingEffects(self.robot, self.catalogue, models, values)
        if self.robot.model.nhistory:
            routes = command_routes(self.robot, self.catalogue, values)
            if (before := filled_histories(models.batch.model, windows, *routes)) is not None:
                models.batch.bind("history")[:] = before
        return _Prepared(values, LaneSteps(models, acting), self._displayed(acting))

    def _is_finer(self, windows: Sequence[Window]) -> bool:
        """Whether there are steps shorter than the robot's own, pauses left out."""
        step = float(self.robot.model.opt.timestep)
        return any(
            ((w.steps.length > 0.0) & (w.steps.length < step)).any() for w in {id(w): w for w in windows}.values()
        )

    def _displayed(self, acting: ActingEffects) -> list[ShownVariable]:
        found = []
        for s in motor_readings(self.robot, self.catalogue):
            for term in acting.terms:
                if term.effect.name == s.effect and (there := np.flatnonzero(term.site == s.row)).size:
                    found.append(ShownVariable(s.effect, s.state, there, term.lane[there], s.column, s.factor))
        return found

    def _rested(self, prepared: _Prepared, roll: RolledRows) -> LaneHidden:
        acting, rows = prepared.steps.acting, [np.asarray(x).T for x in roll]
        acting.begin(*rows)
        with np.errstate(all="ignore"):
            return acting.rest()

    def _rolled(self, prepared: _Prepared, hidden: LaneHidden, roll: RolledRows) -> LaneHidden:
        acting = prepared.steps.acting
        for k in np.flatnonzero((roll.length > 0.0).any(axis=1)):
            acting.begin(*(np.asarray(x[k]).T for x in roll))
            with np.errstate(all="ignore"):
                hidden = acting.kept(roll.length[k] > 0.0, hidden, acting.roll(hidden))
        return hidden

    def _advanced(
        self, prepared: _Prepared, state: LaneBatchState, drive: CommandSteps
    ) -> tuple[LaneBatchState, StepReadings]:
        with np.errstate(all="ignore"):
            after, found = prepared.steps.advance(state, drive, prepared.displayed)
        distort_readings(self.robot, self.catalogue, prepared.values, found.sensors)
        return after, found
