"""Where a run of the estimation-exploration algorithm stands: everything it needs to go on, and all it has found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple, final

import numpy as np

from estexp_jax.physics.effects.changes import Change
from estexp_jax.recovery.control.trial import Trial


class Row(NamedTuple):
    """A generation, as in `history.parquet`."""

    number: int  #: pass: 0 for the first exploration, then as in `RunState.number`
    phase: str  #: exploration or estimation
    generation: int  #: from 1; for the set search: rounds
    best: float  #: m for exploration, the metric for estimation
    median: float
    dominant: int  #: new genomes better than all of the generation before


class Pass(NamedTuple):
    """One estimation, the exploration after it, and its hardware trial."""

    diagnosis: tuple[Change, ...]
    residual: float  #: the metric of the diagnosis on the trials before
    probability: float | None
    rivals: tuple[tuple[tuple[Change, ...], float], ...]  #: what it could not exclude, with probabilities
    alarm: bool | None  #: whether nothing in the catalogue reproduces the recordings
    simulated: float  #: m that the best controller comes in the diagnosed simulator
    hardware: float  #: m that it comes on the robot


@final
@dataclass(frozen=True, eq=False)
class RunState:
    """A run between two generations; never changed, only replaced.

    Attributes:
        phase: what comes next: exploration, damage, estimation, trial or done.
        number: pass: 0 before the damage, then 1 to the number of passes.
        search: state of the phase under way, a tree; None between phases.
        controllers: best controller of each exploration, (n_weights,).
        simulated: distance of each in the simulator as diagnosed then, m.
        diagnoses: one for each estimation.
        residuals, probabilities: of the diagnoses.
        rivals: of each diagnosis, what it could not exclude, with probabilities.
        alarms: of each diagnosis, whether nothing in the catalogue reproduces the recordings; None: nobody knows.
        seeds: for the next estimation, trees.
        before: the robot before the damage, under the first controller; None until then.
        trials: of the damaged robot; `trials[i]` is under `controllers[i]`.
        history: all generations so far.
    """

    phase: str = "exploration"
    number: int = 0
    search: Mapping[str, Any] | None = None
    controllers: tuple[np.ndarray, ...] = ()
    simulated: tuple[float, ...] = ()
    diagnoses: tuple[tuple[Change, ...], ...] = ()
    residuals: tuple[float, ...] = ()
    probabilities: tuple[float | None, ...] = ()
    rivals: tuple[tuple[tuple[tuple[Change, ...], float], ...], ...] = ()
    alarms: tuple[bool | None, ...] = ()
    seeds: tuple[Any, ...] = ()
    before: Trial | None = None
    trials: tuple[Trial, ...] = ()
    history: tuple[Row, ...] = ()

    def passes(self, axis: str) -> tuple[Pass, ...]:
        """The passes that have had their trial."""
        told = zip(
            self.diagnoses,
            self.residuals,
            self.probabilities,
            self.rivals or [()] * len(self.diagnoses),
            self.alarms or [None] * len(self.diagnoses),
            self.simulated[1:],
            self.trials[1:],
            strict=False,
        )
        return tuple(Pass(d, r, p, o, a, s, trial.distance(axis)) for d, r, p, o, a, s, trial in told)

    def to_tree(self) -> dict[str, Any]:
        """What a checkpoint holds."""
        tree = {f.name: getattr(self, f.name) for f in fields(self)}
        return {
            **tree,
            "diagnoses": [[change.to_json() for change in diagnosis] for diagnosis in self.diagnoses],
            "rivals": [[([c.to_json() for c in changes], p) for changes, p in told] for told in self.rivals],
            "before": None if self.before is None else self.before.to_tree(),
            "trials": [trial.to_tree() for trial in self.trials],
            "history": [tuple(row) for row in self.history],
        }

    @classmethod
    def from_tree(cls, tree: Mapping[str, Any]) -> RunState:
        """The inverse of `to_tree`."""
        state = cls(**tree)
        return replace(
            state,
            diagnoses=tuple(tuple(Change.from_json(c) for c in diagnosis) for diagnosis in tree["diagnoses"]),
            rivals=tuple(
                tuple((tuple(Change.from_json(c) for c in changes), p) for changes, p in told)
                for told in tree.get("rivals", ())
            ),
            before=None if tree["before"] is None else Trial.from_tree(tree["before"]),
            trials=tuple(Trial.from_tree(trial) for trial in tree["trials"]),
            history=tuple(Row(*row) for row in tree["history"]),
        )
