"""Explaining by the joint sparse fit: where it applies, and its result as an explanation to be tested."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from typing import Any

import mujoco
import numpy as np

from estexp_jax.discovery.comparison import apart_in, problem_of, replayer_of
from estexp_jax.discovery.diagnosis import Case, Diagnosis, ExplainConfig
from estexp_jax.discovery.findings_json import Found, diagnosis
from estexp_jax.discovery.fitting import Progress
from estexp_jax.discovery.hypotheses import known_values, parameters_only, simulated
from estexp_jax.discovery.joint.criteria import SelectionCriteria
from estexp_jax.discovery.joint.fit import JointSearch
from estexp_jax.discovery.joint.judgement import Judged, judged_alone, judged_beside
from estexp_jax.discovery.joint.problem import JointProblem
from estexp_jax.discovery.joint.reading_stage import JointFit
from estexp_jax.discovery.marginal import about
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.rivals import base_of, black_box_errors
from estexp_jax.discovery.selection import NOISE, Selection, probabilities, simplest, worth
from estexp_jax.discovery.shown_time_step import resolved
from estexp_jax.discovery.slopes import Fit
from estexp_jax.discovery.verdict import is_wrong_value
from estexp_jax.estimation.parameters import ParameterSpace
from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.effects.registry import effect, every
from estexp_jax.physics.effects.sites import driven_joint_sites, scalar_joint_sites
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording

_CRITERIA = SelectionCriteria()


def is_jointly_fitted(case: Case) -> bool:
    """Whether a robot has only hinges and slides, all driven and all measured, so that torques can be balanced."""
    robot, model = case.robot, case.robot.model
    if len(robot.scalar_joints) != model.njnt:
        return False
    driven = driven_joint_sites(robot) == scalar_joint_sites(robot)
    return driven and all(_is_measured(robot, r) for r in case.recordings)


def _is_measured(robot: Robot, recording: Recording) -> bool:
    model = robot.model
    columns = {
        int(model.sensor_objid[s]): int(model.sensor_adr[s])
        for s in range(model.nsensor)
        if model.sensor_type[s] == int(mujoco.mjtSensor.mjSENS_JOINTPOS)
    }
    return all(
        np.isfinite(recording.qpos[:, model.jnt_qposadr[j]]).any()
        or (j in columns and np.isfinite(recording.sensor[:, columns[j]]).any())
        for j in robot.scalar_joints
    )


def explain_jointly(
    case: Case, config: ExplainConfig, memory: dict[str, Any]
) -> Generator[Progress, None, Diagnosis | None]:
    """Explain by the joint sparse fit; None where it does not apply, or where another strategy may know better.

    Args:
        case: what is to be explained.
        config: how.
        memory: of the caller's checkpoint.

    Yields:
        Progress.
    """
    if not is_jointly_fitted(case):
        return None
    whole, problem = joint_problem_of(case, config, memory.setdefault("joint fit", {}))
    search = JointSearch(problem, _CRITERIA)
    fit = (yield from search.first()).fit
    space, parameters = search.space, parameters_only(case.robot, whole.replayer.catalogue, problem.known)
    if sum(not is_wrong_value(case.robot, c) for c in _claims(fit, space)) >= _CRITERIA.fewest_effects - 1:
        fit = yield from search.grown(fit)
    fit = search.settled(fit)
    bent = yield from search.values_only()
    yield Progress("held-out windows", 0, 1)
    judged = judged_alone(whole, search, parameters, fit, bent)
    if not _suffices(case.robot, judged.selection):
        return None
    rivals = yield from search.rivals(fit)
    judged = judged_beside(judged, search, parameters, rivals)
    plain, likely = _plainly_better(judged.selection, rivals), _likelier(judged.selection, rivals)
    better = plain or likely
    if better is not None:  # what stands in for an effect may take several others; its replacement shows them needless
        other = search.settled(better)
        instead = judged_alone(whole, search, parameters, other, bent)
        if plain is not None or instead.selection.chosen.error < judged.selection.chosen.error:
            fit, rivals = other, (yield from search.rivals(other))
            judged = judged_beside(instead, search, parameters, rivals)
            if not _suffices(case.robot, judged.selection) or _plainly_better(judged.selection, rivals) is not None:
                return None
    intervals = _intervals(space, judged.fits["explained"], fit)
    return (yield from _told(case, config, judged, intervals))


def _plainly_better(selection: Selection, rivals: Sequence[JointFit]) -> JointFit | None:
    """The best rival that held-out windows plainly prefer to the choice, None if there is none."""
    by_places = {e.places: e for e in selection.tried}
    found = [(by_places[r.places], r) for r in rivals if worth(by_places[r.places], selection.chosen)]
    return min(found, key=lambda both: both[0].error)[1] if found else None


def _likelier(selection: Selection, rivals: Sequence[JointFit]) -> JointFit | None:
    """The likeliest rival, if it is likelier than the choice and no near tie of it: what is told first is likeliest."""
    each = probabilities(selection, 0)[1:]
    share = {e.places: p for e, p in zip(selection.tried, each, strict=True)}
    best = max(rivals, key=lambda r: share[r.places], default=None)
    if best is None or share[best.places] <= share[selection.chosen.places]:
        return None
    fitted = next(e for e in selection.tried if e.places == best.places)
    return best if simplest([selection.chosen, fitted]) is fitted else None


def _claims(fit: JointFit, space: ParameterSpace) -> list[Change]:
    """A fit's effects with their values."""
    values = {i: (space.parameters[i].name, float(fit.point[i])) for p in fit.places for i in space.of_place[p]}
    return [
        Change(name, site or None, dict(values[i] for i in space.of_place[name, site])) for name, site in fit.places
    ]


def _suffices(robot: Robot, selection: Selection) -> bool:
    """Whether nothing but noise is left to explain, or more is missing than the stepwise search adds in time."""
    chosen = selection.chosen
    missing = sum(not is_wrong_value(robot, change) for change in chosen.claims)
    if chosen.error <= NOISE and missing == len(chosen.claims):
        return True
    return missing >= _CRITERIA.fewest_effects and chosen.error < selection.parameters.error


def joint_problem_of(case: Case, config: ExplainConfig, memory: dict[str, Any]) -> tuple[Problem, JointProblem]:
    """The comparison of all windows, and what the joint fit explains; arguments as of `explain_jointly`."""
    whole = problem_of(case, config, memory)
    settings = {name for r in case.recordings for name in r.settings}
    known = known_values(case.robot, settings)
    names = dict.fromkeys([*simulated(config.effects), *(e.name for e in every() if e.is_constant_torque)])
    apart = apart_in(case, whole.segments, case.indices("train"))
    parameters = parameters_only(case.robot, whole.replayer.catalogue, known)
    lacking = about(whole, Fit(parameters, parameters.start(), np.inf)).lacking
    same = set(names) == {e.name for e in whole.replayer.catalogue}
    simulator = whole.replayer if same else replayer_of(case, config, list(names), apart, whole.segments)
    places = {p for p in whole.places if p[0] in config.effects and effect(p[0]).named and not effect(p[0]).variant_of}
    return whole, JointProblem(
        case.robots, whole.recordings, whole.channels, simulator, places, known, whole.seen, lacking, whole.counted
    )


def _intervals(space: ParameterSpace, explained: Fit, fit: JointFit) -> np.ndarray:
    """90 % intervals (n_free, 2) of the explained fit's values; of what was not free, the value itself."""
    std = np.zeros(len(space.parameters))
    std[fit.indices] = fit.std
    index = {(p.effect, p.site, p.name): i for i, p in enumerate(space.parameters)}
    # The least values stay bounds; the largest come from what motors could do, which the recordings may exceed.
    reach = _CRITERIA.interval * np.array(
        [std[index[f.effect, f.site, f.parameter]] for f in explained.hypothesis.free]
    )
    low = np.minimum([f.low for f in explained.hypothesis.free], explained.vector)
    return np.stack([np.maximum(explained.vector - reach, low), explained.vector + reach], axis=1)


def _told(
    case: Case, config: ExplainConfig, judged: Judged, intervals: np.ndarray
) -> Generator[Progress, None, Diagnosis]:
    """The result, proven on the test recordings."""
    selection, fits, problem, _ = judged
    yield Progress("black box", 0, 1)
    bases = [base_of(case, problem, fits[name]) for name in ("parameters_only", "nominal")]
    learned = black_box_errors(case, config, problem, bases)
    yield Progress("test recordings", 0, 1)
    shown = resolved(case, problem, problem, fits["explained"].member)
    found = Found(problem, shown, selection, fits, learned, bases[0][1], intervals=intervals)
    return diagnosis(case, config, found)
