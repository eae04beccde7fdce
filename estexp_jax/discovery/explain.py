"""Explaining recordings: compare, refit, hypothesise, choose on held-out windows, prove on test recordings."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from estexp_jax.discovery import findings as tell
from estexp_jax.discovery.diagnosis import Case, Diagnosis, ExplainConfig, Prediction
from estexp_jax.discovery.export import expressible
from estexp_jax.discovery.fitting import Fit, Progress, Task, fit
from estexp_jax.discovery.force_residual import ForceResidual
from estexp_jax.discovery.hypotheses import claimable, claiming, known_values, parameters_only, simulated, singles
from estexp_jax.discovery.late import begun, select_late, starting_late
from estexp_jax.discovery.location import where
from estexp_jax.discovery.marginal import about
from estexp_jax.discovery.numerics import step_entry, step_place, step_to_blame
from estexp_jax.discovery.placebo import placebo
from estexp_jax.discovery.problem import Problem, deviations
from estexp_jax.discovery.rivals import RIVALS, base_of, black_box_errors, fit_entry
from estexp_jax.discovery.searching import fitted, select
from estexp_jax.discovery.selection import Selection, probabilities
from estexp_jax.discovery.uncertainty import parameter_intervals
from estexp_jax.discovery.verdict import bent_values, verdict
from estexp_jax.discovery.when import never, when
from estexp_jax.inference.channels import channels_of
from estexp_jax.inference.gaps import bridged
from estexp_jax.inference.windows import segments_of
from estexp_jax.physics.changes import Change
from estexp_jax.physics.engines.choice import replayer
from estexp_jax.physics.registry import catalogue

FINER = 4
"""The explained simulator steps at this part of the nominal step."""


def problem_of(case: Case, config: ExplainConfig, memory: dict[str, Any]) -> Problem:
    """The comparison of a case, with windows of the configured length.

    Raises:
        InputError: the model cannot be simulated, or there is no reading to compare.
    """
    simulator = replayer(case.robot, catalogue(simulated(config.effects)), case.robots, engine=config.engine)
    places = tuple(singles(case.robot, catalogue(claimable(config.effects))))
    recordings = tuple(map(bridged, case.recordings))
    coarse, fine = (tuple(segments_of(case.robots, recordings, config.window, finer)) for finer in (1, FINER))
    channels = channels_of(case.robot, recordings)
    noise = deviations(channels, recordings)
    return Problem(simulator, recordings, coarse, fine, channels, [0], memory, noise, places)


def explain(
    case: Case, config: ExplainConfig, memory: dict[str, Any] | None = None
) -> Generator[Progress, None, Diagnosis]:
    """Explain a case. Test recordings are looked at only after everything is chosen and fitted.

    Args:
        case: what is to be explained.
        config: how.
        memory: what an interrupted explanation of the same case had found; filled further as this one goes on.

    Yields:
        Progress.

    Raises:
        InputError: the model cannot be simulated, or there is no reading to compare.
    """
    whole = problem_of(case, config, {} if memory is None else memory)
    engine, reason = whole.replayer.choice
    yield Progress("replaying the nominal simulator", 0, 1, f"engine: {engine}, {reason}")
    settings = {name for r in case.recordings for name in r.settings}
    parameters = parameters_only(case.robot, whole.replayer.catalogue, known_values(case.robot, settings))
    nominal = Fit(parameters, parameters.start(), np.inf)
    selection, problem = yield from select(whole, parameters, config.most)
    began = begun(case, problem, selection, config.seed)
    if began:
        late = starting_late(case, config, problem, began, FINER)
        better = yield from select_late(late, parameters, selection, config.most)
        (selection, problem), began = (better, began) if better else ((selection, problem), {})
    fits = {"nominal": nominal, **(yield from _refitted(problem, selection))}
    yield Progress("black box", 0, 1)
    shown = replace(whole, began=began)
    bases = [base_of(case, shown, fits[name]) for name in ("parameters_only", "nominal")]
    learned = black_box_errors(case, config, shown, bases)
    yield Progress("test recordings", 0, 1)
    return _diagnosis(case, config, problem, shown, selection, fits, learned, bases[0][1])


def _refitted(problem: Problem, selection: Selection) -> Generator[Progress, None, dict[str, Fit]]:
    """The chosen explanation, its part that MJCF can say, and its rivals, fitted to all training windows."""
    chosen, parameters = selection.chosen.fitted, selection.parameters.fitted
    changes = chosen.hypothesis.changes(chosen.vector, claimed=True)
    said = [c for c in (c if expressible(c) else tell.told_change(c) for c in changes) if expressible(c)]
    sayable = claiming(problem.replayer.robot, parameters.hypothesis, [(c.effect, c.name or "") for c in said])
    known = {(f.effect, f.site, f.parameter): v for f, v in zip(chosen.hypothesis.free, chosen.vector, strict=True)}
    known |= {(c.effect, c.name or "", name): v for c in said for name, v in c.parameters.items()}
    start = np.array([known.get((f.effect, f.site, f.parameter), f.neutral) for f in sayable.free])
    tasks: list[Task] = [
        (chosen.hypothesis, [chosen.vector]),
        (sayable, [start]),
    ]
    wrong = placebo(problem.replayer.robot, parameters.hypothesis, selection)
    tasks += [wrong] if wrong else []
    stage = "all training recordings"
    fits, _ = yield from fitted(problem, tasks, stage, 20)
    by_hypothesis = {f.hypothesis: f for f in fits}
    there = about(problem, parameters).corrected([parameters.member])
    bent: list[Task] = [(parameters.hypothesis, [parameters.vector])]
    price, name = there.price_of(there.fitted), f"{stage}, parameters only"
    [own] = yield from fit(there, bent, there.fitted, price, stage=name, iterations=30)
    kinds = dict(zip(("explained", "sayable", "placebo"), (by_hypothesis[h] for h, _ in tasks), strict=False))
    return {"parameters_only": own, **kinds}


def _diagnosis(
    case: Case,
    config: ExplainConfig,
    problem: Problem,
    shown: Problem,
    selection: Selection,
    fits: dict[str, Fit],
    learned: dict[str, float],
    seen: Sequence[ForceResidual],
) -> Diagnosis:
    nominal, final, sayable = fits["nominal"], fits["explained"], fits["sayable"]
    claimed = final.hypothesis.changes(final.vector, claimed=True)
    found = verdict(case.robot, selection, claimed)
    if found == "consistent":  # then nothing is changed, not even what a refit would bend
        final = sayable = nominal
        fits = {"nominal": nominal, "parameters_only": fits["parameters_only"], "explained": nominal}
        claimed = ()
    step = None
    if found == "parameters" and not claimed:
        error = shown.error(nominal.member, shown.trained)
        step = step_to_blame(selection, error, float(case.robot.model.opt.timestep))
        found = found if step is None else "missing_physics"
    shares = probabilities(selection, config.seed)
    told = (
        bent_values(case.robot, final.hypothesis, final.hypothesis.changes(final.vector))
        if found == "parameters"
        else ()
    )
    intervals = parameter_intervals(problem, final)
    named = () if found in ("consistent", "unexplained") else (*claimed, *told)
    test, exact = shown.windows_of(case.indices("test")), shown.exact()
    places = [] if found == "consistent" else [step_place(selection)] if step else where(case.robot, selection)
    errors = fit_entry(case, config, shown, {name: f for name, f in fits.items() if name in RIVALS}, learned)
    body: dict[str, Any] = {
        "schema": "estexp.findings/1",
        "verdict": found,
        "side": "numerics" if step else tell.side(named),
        "where": places,
        "when": never(case) if step or found == "consistent" else when(case, seen, places, shown.began, config.seed),
        "what": [step_entry(step)]
        if step
        else [
            tell.what_entry(
                c, final, intervals, tell.presence(selection, shares, (c.effect, c.name or "")) if c in claimed else 1.0
            )
            for c in named
        ],
        "alternatives": tell.alternatives(selection, shares, lambda f: exact.error(f.member, test)),
        "fit": errors,
        "advice": tell.advice(found, claimed, case.recordings, shares)
        + tell.step_advice(selection, float(case.robot.model.opt.timestep))
        + tell.black_box_advice(found, errors),
        "data": tell.data_entries(case.recordings),
        "cost": {"wall_s": None, "compile_s": None, "robot_steps": problem.counted[0]},
        "seed": config.seed,
        "versions": {},
    }
    return Diagnosis(
        case,
        config,
        body,
        selection,
        changes=_told(final),
        mjcf_changes=_told(sayable),
        left_out=tuple(c for c in map(tell.told_change, claimed) if not expressible(c)),
        predictions=_predictions(case, shown, nominal, final),
    )


def _told(fitted: Fit) -> tuple[Change, ...]:
    """The changes of a fit, without those that change nothing."""
    off = {(f.effect, f.site) for f, v in zip(fitted.hypothesis.free, fitted.vector, strict=True) if v != f.neutral}
    return tuple(c for c in fitted.hypothesis.changes(fitted.vector) if (c.effect, c.name or "") in off)


def _predictions(case: Case, problem: Problem, nominal: Fit, final: Fit) -> tuple[Prediction, ...]:
    found = []
    for index, recording in enumerate(case.recordings):
        windows = problem.windows_of([index])
        pair = ((replace(problem, step=None), nominal), (problem.exact(), final))
        simulated = [comparison.simulated([f.member], windows)[0] for comparison, f in pair]
        rows = [problem.segments[w].rows for w in windows]
        logged = np.isin(problem.recordings[index].time, recording.time)
        joined = [np.concatenate([s[k, :n] for k, n in enumerate(rows)])[logged] for s in simulated]
        number = np.repeat(np.arange(len(windows)), rows)[logged]
        recorded = problem.channels.recorded(recording)
        prediction = Prediction(
            recording.name,
            recording.role,
            recording.time,
            number,
            problem.channels.names,
            recorded,
            joined[0],
            joined[1],
        )
        found.append(prediction)
    return tuple(found)
