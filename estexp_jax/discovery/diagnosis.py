"""What an explanation of recordings consists of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, final

import numpy as np

from estexp_jax.discovery.competing_models import CompetingModels
from estexp_jax.discovery.law_forces import LawForces
from estexp_jax.discovery.selection import Selection
from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.effects.registry import named_effects
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording


@final
@dataclass(frozen=True, eq=False)
class Case:
    """Recordings of a robot and its nominal simulator.

    Attributes:
        robot: the nominal robot.
        recordings: training and test recordings, at least one of each.
        robots: for each recording, the nominal robot with what is known of that recording.
        standing: what the robot has in all of them and no MJCF can hold: found when it was healthy, so no news.
        discrepancy: by a reading's name, how far the simulator was off when the robot was healthy, for reasons that
            nobody found: it counts as noise.
    """

    robot: Robot
    recordings: tuple[Recording, ...]
    robots: tuple[Robot, ...]
    standing: tuple[Change, ...] = ()
    discrepancy: Mapping[str, float] = field(default_factory=dict)

    def indices(self, role: str) -> list[int]:
        """Indices of the recordings of a role."""
        return [i for i, r in enumerate(self.recordings) if r.role == role]


def explaining() -> tuple[str, ...]:
    """Names of the effects that recordings are explained by: no network is behind their commands."""
    return tuple(e.name for e in named_effects() if e.kind != "controller")


@final
@dataclass(frozen=True)
class ExplainConfig:
    """How to explain.

    Attributes:
        window: length of the windows that are fitted, compared and written, s; infinite for whole recordings.
        most: largest number of effects in an explanation.
        effects: names of the effects to consider.
        seed: of the resampling behind probabilities and intervals.
        engine: auto, lanes, c or mjx.
        for_mjx: whether the corrected model is meant for MJX, so that it keeps to what that simulates.
    """

    window: float = 2.0
    most: int = 5
    effects: tuple[str, ...] = field(default_factory=explaining)
    seed: int = 0
    engine: str = "auto"
    for_mjx: bool = False


@final
@dataclass(frozen=True, eq=False)
class Prediction:
    """One recording beside the two simulators.

    Attributes:
        recording: its file name.
        role: train or test.
        time: (rows,) s.
        window: (rows,) number of the window each row lies in.
        channels: names of the readings.
        recorded, nominal, explained: (rows, channels); NaN where there is no sample.
    """

    recording: str
    role: str
    time: np.ndarray
    window: np.ndarray
    channels: tuple[str, ...]
    recorded: np.ndarray
    nominal: np.ndarray
    explained: np.ndarray


@final
@dataclass(frozen=True)
class NativeModel:
    """What `model_explained.xml` holds.

    Attributes:
        changes: what the file holds.
        left_out: the claims that MJCF cannot hold, and why.
        errors: of the file, by role; of training recordings in evenly spread windows.
        finer: part of the model's own step that it takes: 1 unless that step is what is wrong.
        fine: whether a second file, at the step of the explained simulator, predicts plainly better.
        stand_in: what another file holds that stands in for what is left out, and predicts plainly better; else None.
    """

    changes: tuple[Change, ...]
    left_out: tuple[tuple[Change, str], ...]
    errors: Mapping[str, float]
    finer: int = 1
    fine: bool = False
    stand_in: tuple[Change, ...] | None = None


@final
@dataclass(frozen=True, eq=False)
class Diagnosis:
    """What was found.

    Attributes:
        case: what was explained.
        config: how.
        findings: as in `findings.json`, but for cost and versions, which the caller knows.
        selection: all explanations tried.
        changes: the explained simulator: claimed effects and refitted values of the model.
        native: what `model_explained.xml` holds, and what it leaves out.
        predictions: one for each recording.
        finer: part of the model's own step that the explained simulator takes.
        rivals_finer: the same of its rivals.
        competing_models: the explanations that remain open; None: not looked at.
        laws: what unknown laws do where the training recordings show their joints.
    """

    case: Case
    config: ExplainConfig
    findings: dict[str, Any]
    selection: Selection
    changes: tuple[Change, ...]
    native: NativeModel
    predictions: tuple[Prediction, ...]
    finer: int
    rivals_finer: int
    competing_models: CompetingModels | None = None
    laws: tuple[LawForces, ...] = ()
