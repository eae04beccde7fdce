"""Recordings put right before physics is looked for, and their faults told before it.

Training recordings decide. What all of them show is undone in test recordings as well, with the same numbers; these
then only say whether they bear it out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np

from estexp_jax.discovery.clock_doubt import MOST_PROBABLE
from estexp_jax.discovery.comparison import problem_of
from estexp_jax.discovery.diagnosis import Case, Diagnosis, ExplainConfig, Prediction
from estexp_jax.discovery.hypotheses import known_values, parameters_only
from estexp_jax.discovery.intervals import gain_interval
from estexp_jax.discovery.regime import THROUGHOUT
from estexp_jax.discovery.shown import NOMINAL, Shown, shown_by
from estexp_jax.discovery.slopes import Fit
from estexp_jax.estimation.accuracy import gain
from estexp_jax.estimation.log_faults import FoundFault, found_faults
from estexp_jax.estimation.log_replay import log_replay_of
from estexp_jax.physics.effects.changes import Change, sentence_of
from estexp_jax.physics.effects.logging_fault import LoggingFault
from estexp_jax.physics.effects.registry import logging_faults
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording

_90 = 1.645
"""Deviations to either side within which 90 % lie."""
_TOLD = 0.02
"""Smallest share of a place worth a line."""


@final
@dataclass(frozen=True)
class MendedFault:
    """A fault of logging that was undone.

    Attributes:
        change: the fault with its numbers.
        deviation: of the first of them; 0 where there is none.
        probability: that it is there.
        recordings: names of those it was undone in.
        everywhere: whether that is every training recording.
        refuted: whether test recordings do not bear it out.
    """

    change: Change
    deviation: float
    probability: float
    recordings: tuple[str, ...]
    everywhere: bool
    refuted: bool = False


def mended(case: Case, config: ExplainConfig) -> tuple[Case, tuple[MendedFault, ...]]:
    """A case with its recordings put right, and the faults that were undone; itself where there are none.

    Args:
        case: what is to be explained.
        config: how; of its effects only faults of logging count here.
    """
    names = {e.name for e in logging_faults()} & set(config.effects)
    if not names:
        return case, ()
    train = case.indices("train")
    found = dict[int, tuple[FoundFault, ...]]()
    for i in train:
        worth_while = not found or any(found.values())
        found[i] = found_faults(case.robots[i], case.recordings[i], names, beside_physics=worth_while)[0]
    undone = {i: [f for f in faults if _effect(f.change).is_undone(f.change.values)] for i, faults in found.items()}
    groups: dict[tuple[str, ...], dict[int, FoundFault]] = {}
    for i, faults in undone.items():
        for fault in faults:
            groups.setdefault(_key(fault.change), {})[i] = fault
    if not groups:
        return case, ()
    faults, recordings = [], list(case.recordings)
    for group in groups.values():
        everywhere = len(group) == len(train)
        one = _common(case, group, everywhere)
        tests = case.indices("test") if everywhere else []
        refuted = [i for i in tests if not _borne_out(case.robots[i], recordings[i], one.change)]
        for i in (*group, *tests):
            recordings[i] = _put_right(case.robots[i], recordings[i], one.change)
        faults.append(replace(one, refuted=bool(refuted)))
    return replace(case, recordings=tuple(recordings)), tuple(faults)


def with_faults(diagnosis: Diagnosis, case: Case, config: ExplainConfig, faults: Sequence[MendedFault]) -> Diagnosis:
    """What was found in a case that was put right, with its faults told first.

    Args:
        diagnosis: of the case that was put right.
        case: as it was logged.
        config: how it was explained.
        faults: that were undone.
    """
    if not faults:
        return diagnosis
    body, robot = diagnosis.findings, case.robot
    removed = min(max(f.probability for f in faults), 1.0 - _TOLD)
    others = [{**place, "share": (1.0 - removed) * place["share"]} for place in body["where"]]
    places = [
        {"kind": f.change.kind, "name": f.change.name, "share": removed / len(faults), "p_value": None} for f in faults
    ]
    regime = body["when"]["regime"] or THROUGHOUT
    left = ["With the logs put right, what is left of the mismatch is unexplained."]
    told = {
        "verdict": "missing_physics",
        "side": _effect(faults[0].change).side,
        "where": [*places, *(place for place in others if place["share"] >= _TOLD)],
        "when": {**body["when"], "regime": regime},
        "what": [*(_entry(robot, fault) for fault in faults), *body["what"]],
        "alternatives": [
            {**other, "effects": [*(f.change.place for f in faults), *other["effects"]]}
            for other in body["alternatives"]
        ],
        "fit": _fit(diagnosis, case, config),
        "advice": [
            *(_line(robot, fault) for fault in faults),
            *dict.fromkeys(line for f in faults for line in _effect(f.change).advice(case.recordings)),
            *(left if body["verdict"] == "unexplained" else []),
            *body["advice"],
        ],
    }
    return replace(diagnosis, findings={**body, **told})


def _effect(change: Change) -> LoggingFault:
    return next(e for e in logging_faults() if e.name == change.effect)


def _key(change: Change) -> tuple[str, ...]:
    """What is the same of one fault in several recordings."""
    chosen = (str(change.values[p.name]) for p in _effect(change).parameters if p.refers)
    return change.effect, change.name or "", *chosen


def _common(case: Case, group: dict[int, FoundFault], everywhere: bool) -> MendedFault:
    """The fault of several recordings, its number the median of theirs."""
    found = list(group.values())
    values = {name: float(np.median([f.change.values[name] for f in found])) for name in found[0].change.values}
    change = Change(found[0].change.effect, found[0].change.name, values)
    deviation = float(np.median([f.deviation for f in found])) / np.sqrt(len(found))
    probability = float(np.mean([f.probability for f in found]))
    return MendedFault(change, deviation, probability, tuple(case.recordings[i].name for i in group), everywhere)


def _put_right(robot: Robot, recording: Recording, change: Change) -> Recording:
    effect = _effect(change)
    right = effect.mended(robot, recording, change.name or "", change.values)
    note = f"put right: {sentence_of(robot, change)}"
    doubts = () if effect.displaces_time else right.clock_faults
    return replace(right, notes=(*right.notes, note), clock_faults=doubts)


def _borne_out(robot: Robot, recording: Recording, change: Change) -> bool:
    """Whether a recording that decided nothing shows a fault, too."""
    effect = _effect(change)
    if effect.plain(robot, change.name or "", recording) is not None:
        return True
    replay = log_replay_of(robot, recording)
    if replay is None:
        return False
    right = effect.mended(robot, recording, change.name or "", change.values)
    before, after = replay.errors([recording, right])
    return bool(after < before)


def _entry(robot: Robot, fault: MendedFault) -> dict[str, Any]:
    """Its entry in `what`."""
    change, effect = fault.change, _effect(fault.change)
    where = "" if fault.everywhere else f", in {' and '.join(fault.recordings)}"
    doubt = "; but the test recordings do not bear it out" if fault.refuted else ""
    first, low, high = effect.parameters[0].name, -_90 * fault.deviation, _90 * fault.deviation
    parameters = {
        p.name: {
            "value": change.values[p.name],
            "low": change.values[p.name] + (low if p.name == first else 0.0),
            "high": change.values[p.name] + (high if p.name == first else 0.0),
            "unit": p.unit,
        }
        for p in effect.parameters
    }
    return {
        "effect": effect.name,
        "kind": effect.kind,
        "name": change.name,
        "probability": min(fault.probability, MOST_PROBABLE if fault.refuted else 1.0),
        "in_mjcf": False,
        "sentence": f"{sentence_of(robot, change)}{where}{doubt}",
        "equation": effect.equation,
        "parameters": parameters,
    }


def _line(robot: Robot, fault: MendedFault) -> str:
    where = "All training recordings" if fault.everywhere else " and ".join(fault.recordings)
    return f"{where} were put right before anything was fitted: {sentence_of(robot, fault.change)}."


def _fit(diagnosis: Diagnosis, case: Case, config: ExplainConfig) -> dict[str, Any]:
    """The errors, with those of the nominal simulator beside the recordings as they were logged."""
    fit = diagnosis.findings["fit"]
    shown = _nominal_as_logged(case, config)
    windows = {role: shown.problem.windows_of(case.indices(role)) for role in ("train", "test")}
    nominal = {role: shown.error(NOMINAL, w) for role, w in windows.items()}
    floor = fit["noise_floor"]["test"]
    before, after = shown.costs(NOMINAL, windows["test"]), _costs(diagnosis.predictions)
    count = min(len(before), len(after))
    low, high = gain_interval(before[:count], after[:count], floor, config.seed)
    value = gain(fit["explained"]["test"], nominal["test"], floor)
    return {**fit, "nominal": nominal, "gain": {"value": value, "low": float(low), "high": float(high)}}


def _nominal_as_logged(case: Case, config: ExplainConfig) -> Shown:
    problem = problem_of(case, config, {})
    settings = {name for r in case.recordings for name in r.settings}
    nothing = parameters_only(case.robot, problem.replayer.catalogue, known_values(case.robot, settings))
    return shown_by(problem, {NOMINAL: Fit(nothing, nothing.start(), np.inf)})


def _costs(predictions: Sequence[Prediction]) -> np.ndarray:
    """Mean squared errors over squared ranges of each window of the test recordings, of the explained simulator."""
    found = []
    for p in (p for p in predictions if p.role == "test"):
        spans = np.nanmax(p.recorded, axis=0) - np.nanmin(p.recorded, axis=0)
        shares = np.square((p.explained - p.recorded) / np.where(spans > 0.0, spans, 1.0))
        found += [float(np.nanmean(shares[p.window == w])) for w in np.unique(p.window)]
    return np.array(found)
