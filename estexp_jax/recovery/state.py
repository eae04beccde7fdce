"""State of a run of the estimation-exploration algorithm: results so far, and all that is needed to resume."""

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
    generation: int  #: from 1; for the set search: iterations
    best: float  #: m for exploration, the metric for estimation
    median: float
    dominant: int  #: new genomes better than all of the generation before


class Pass(NamedTuple):
    """One estimation, the exploration after it, and the hardware trial."""

    diagnosis: tuple[Change, ...]
    residual: float  #: cost of the diagnosis on the trials before
    probability: float | None
    alternatives: tuple[tuple[tuple[Change, ...], float], ...]  #: explanations not excluded, with probabilities
    alarm: bool | None  #: whether no hypothesis of the catalogue reproduces the recordings
    simulated: float  #: distance of the best controller in the diagnosed simulator, m
    hardware: float  #: its distance on the robot, m


@final
@dataclass(frozen=True, eq=False)
class RunState:
    """Immutable state of a run between two generations.

    Attributes:
        phase: the next one: exploration, damage, estimation, trial or done.
        number: of the pass: 0 before the damage, then 1 to the number of passes.
        search: state of the present phase's search, a tree; None between phases.
        controllers: best controller of each exploration, (n_weights,) each.
        simulated: distance of each in the simulator as diagnosed at that time, m.
        diagnoses: one for each estimation.
        residuals, probabilities: of the diagnoses.
        alternatives: for each diagnosis, the explanations not excluded, with their probabilities.
        alarms: for each diagnosis, whether no hypothesis of the catalogue reproduces the recordings; None: unknown.
        seeds: initial hypotheses of the next estimation, trees.
        before: trial of the first controller before the damage; None until then.
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
    alternatives: tuple[tuple[tuple[tuple[Change, ...], float], ...], ...] = ()
    alarms: tuple[bool | None, ...] = ()
    seeds: tuple[Any, ...] = ()
    before: Trial | None = None
    trials: tuple[Trial, ...] = ()
    history: tuple[Row, ...] = ()

    def passes(self, axis: str) -> tuple[Pass, ...]:
        """The passes whose trial is done; distances are along `axis`."""
        columns = zip(
            self.diagnoses,
            self.residuals,
            self.probabilities,
            self.alternatives or [()] * len(self.diagnoses),
            self.alarms or [None] * len(self.diagnoses),
            self.simulated[1:],
            self.trials[1:],
            strict=False,
        )
        return tuple(Pass(d, r, p, o, a, s, trial.distance(axis)) for d, r, p, o, a, s, trial in columns)

    def to_tree(self) -> dict[str, Any]:
        """The tree of plain data that a checkpoint holds."""
        tree = {f.name: getattr(self, f.name) for f in fields(self)}
        others = [[([c.to_json() for c in changes], p) for changes, p in each] for each in self.alternatives]
        return {
            **tree,
            "diagnoses": [[change.to_json() for change in diagnosis] for diagnosis in self.diagnoses],
            "alternatives": others,
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
            alternatives=tuple(
                tuple((tuple(Change.from_json(c) for c in changes), p) for changes, p in each)
                for each in tree.get("alternatives", ())
            ),
            before=None if tree["before"] is None else Trial.from_tree(tree["before"]),
            trials=tuple(Trial.from_tree(trial) for trial in tree["trials"]),
            history=tuple(Row(*row) for row in tree["history"]),
        )
