"""Explaining recordings: compare, refit, hypothesise, choose on held-out windows, prove on test recordings."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from estexp_jax.discovery import findings as tell
from estexp_jax.discovery.comparison import apart_in, problem_of, replayer_of, shortened, shown_of, to_fit
from estexp_jax.discovery.diagnosis import Case, Diagnosis, ExplainConfig
from estexp_jax.discovery.export import expressible
from estexp_jax.discovery.findings_json import Found, diagnosis
from estexp_jax.discovery.fitting import Progress, Task, fit
from estexp_jax.discovery.force_residual import force_residuals
from estexp_jax.discovery.hypotheses import (
    Hypothesis,
    claiming,
    known_values,
    parameters_only,
)
from estexp_jax.discovery.joint.strategy import explain_jointly
from estexp_jax.discovery.law_forces import held
from estexp_jax.discovery.law_plausibility import doubled, is_law, manifold, nearly, needed, without_piles
from estexp_jax.discovery.law_search import Unnamed
from estexp_jax.discovery.laws import lacks_force, unknown_law, unknown_law_nearer
from estexp_jax.discovery.log_mending import mended, with_faults
from estexp_jax.discovery.lost_commands import commanded
from estexp_jax.discovery.marginal import about
from estexp_jax.discovery.onset_claims import begun, select_late, starting_late
from estexp_jax.discovery.onset_date import sharpened
from estexp_jax.discovery.placebo import placebo
from estexp_jax.discovery.possible import still_throughout
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.rivals import base_of, black_box_errors
from estexp_jax.discovery.rounds import fitted
from estexp_jax.discovery.selection import NOISE, Selection
from estexp_jax.discovery.shorter_windows import Nearer, hangs_on_hairs, says_all, select_nearer, shows_unparted
from estexp_jax.discovery.shown_time_step import resolved
from estexp_jax.discovery.single_term import single_term
from estexp_jax.discovery.slopes import Fit
from estexp_jax.discovery.stepwise_search import select
from estexp_jax.discovery.stuck_sensors import frozen
from estexp_jax.discovery.verdict import QUIET, verdict
from estexp_jax.discovery.wave_guesses import with_waves
from estexp_jax.estimation.windows import fitting_window


def explain(
    case: Case, config: ExplainConfig, memory: dict[str, Any] | None = None
) -> Generator[Progress, None, Diagnosis]:
    """Explain a case: its logs are put right first. Test recordings are looked at only after everything is chosen.

    Args:
        case: what is to be explained.
        config: how.
        memory: what an interrupted explanation of the same case had found; filled further as this one goes on.

    Yields:
        Progress.

    Raises:
        InputError: the model cannot be simulated, or there is no reading to compare.
    """
    right, faults = mended(case, config)
    found = yield from _explained(right, config, {} if memory is None else memory)
    return with_faults(found, case, config, faults)


def _explained(case: Case, config: ExplainConfig, memory: dict[str, Any]) -> Generator[Progress, None, Diagnosis]:
    """Explain recordings that are as they should be; arguments as of `explain`."""
    if not (case.standing or case.discrepancy):  # the joint fit knows neither
        jointly = yield from explain_jointly(case, config, memory)
        if jointly is not None:
            return jointly
    whole = problem_of(case, config, memory)
    engine, reason, _ = whole.replayer.choice
    yield Progress("replaying the nominal simulator", 0, 1, f"engine: {engine}, {reason}")
    settings = {name for r in case.recordings for name in r.settings}
    parameters = parameters_only(case.robot, whole.replayer.catalogue, known_values(case.robot, settings))
    nominal = Fit(parameters, parameters.start(), np.inf)
    whole = with_waves(case, commanded(whole, nominal.member))
    selection, problem = yield from select(to_fit(case, config, whole), parameters, config.most)
    usual, nearer = fitting_window(case.robot, config.window) == config.window < np.inf, None
    if usual and hangs_on_hairs(problem, selection):
        shorter = shortened(case, config, whole)
        selection, problem, nearer = yield from select_nearer(shorter, problem, parameters, selection, config.most)
    settled = nearer if nearer is not None and says_all(nearer.selection, selection) else None
    if settled is not None and not settled.selection.chosen.places:  # nothing shows: no law is looked for
        selection, problem = settled
    whole_way, began = (selection, problem), dict[int, float]()
    if settled is None:  # what leaves only noise in all short windows does not begin part-way
        selection, problem, began = yield from _late(case, config, problem, selection, parameters)
    if verdict(case.robot, selection, selection.chosen.claims) == "unexplained":
        if began and _throughout(case, _frozen(*whole_way, parameters)):
            (selection, problem), began = whole_way, {}
        selection = _frozen(selection, problem, parameters)
    named = _Named(selection, problem, began, None if began else nearer)
    selection, problem = yield from _unnamed(case, config, whole, named, parameters)
    if usual and not began:
        last = named._replace(selection=selection, problem=problem)
        selection, problem = yield from _by_shorter(case, config, whole, last, parameters)
    whole = replace(whole, replays=replace(whole.replays, replayer=problem.replayer))
    fits = {"nominal": nominal, **(yield from _refitted(problem, selection))}
    if any(is_law(place) for place in selection.chosen.places):
        seen = force_residuals(problem, [robot.model for robot in case.robots], case.indices("train"))
        fits["explained"] = held(case.robot, seen, fits["explained"])
    yield Progress("black box", 0, 1)
    shown = shown_of(case, config, whole).with_windows(whole.replays.cut, began)
    bases = [base_of(case, shown, fits[name]) for name in ("parameters_only", "nominal")]
    learned = black_box_errors(case, config, shown, bases)
    yield Progress("test recordings", 0, 1)
    shown = resolved(case, problem, shown, fits["explained"].member)
    return diagnosis(case, config, Found(problem, shown, selection, fits, learned, bases[0][1]))


def _late(
    case: Case, config: ExplainConfig, problem: Problem, selection: Selection, parameters: Hypothesis
) -> Generator[Progress, None, tuple[Selection, Problem, dict[int, float]]]:
    """The selection among claims that begin part-way, if they do: with its comparison and the dates, refined by it."""
    began = yield from begun(case, config, problem, selection)
    if not began:
        return selection, problem, {}
    starting_at = partial(starting_late, case, config, problem)
    better = yield from select_late(starting_at(began), parameters, selection, config.most)
    if better is None:
        return selection, problem, {}
    again = yield from sharpened(starting_at, began, better[0].chosen.fitted, "from when on it acts")
    return *better, again


def _frozen(selection: Selection, problem: Problem, parameters: Hypothesis) -> Selection:
    """The selection, with a sensor that is plainly stuck as what was chosen, if there is one."""
    found = frozen(problem, parameters, selection)
    if found is None:
        return selection
    return replace(selection, tried=(*selection.tried, found), chosen=found, seen=True)


def _throughout(case: Case, selection: Selection) -> bool:
    """Whether a sensor that is plainly stuck was chosen, and is so from the first row on."""
    sensors = [site for _, site in selection.chosen.places] if selection.seen else []
    return any(still_throughout(case.robot, sensor, case.recordings) for sensor in sensors)


class _Named(NamedTuple):
    """What was chosen among named effects.

    Attributes:
        selection: with what was chosen.
        problem: the comparison about it.
        began: the onset in each training recording, s; empty where claims act from the start.
        nearer: what was chosen by shorter windows, where motions hang on hairs.
    """

    selection: Selection
    problem: Problem
    began: dict[int, float]
    nearer: Nearer | None


def _unnamed(
    case: Case, config: ExplainConfig, whole: Problem, named: _Named, parameters: Hypothesis
) -> Generator[Progress, None, tuple[Selection, Problem]]:
    """What no name explains, or only many numbers or nearly, as an unknown law if there is one: and its comparison."""
    selection, problem, began = named.selection, named.problem, named.began
    nearer = named.nearer.selection if named.nearer is not None else None
    if nearer is not None and _suffices(case, selection, nearer):
        return selection, problem
    lacking, joint = needed(case.robot, selection), doubled(case.robot, selection)
    rich = manifold(case.robot, selection) or nearly(case.robot, selection)
    if not lacking and joint is None and rich is None:
        return selection, problem
    seen = force_residuals(problem, [robot.model for robot in case.robots], case.indices("train"))
    if joint is None and rich is not None and lacks_force(case.robot, seen, rich):
        joint = rich
    fresh = to_fit(case, config, whole)
    if began:  # the dates that the selection was made with, not those refined by it: its windows are kept
        fresh = starting_late(case, config, fresh, problem.replays.began)
    apart = apart_in(case, whole.segments, case.indices("train"))
    unnamed = Unnamed(case.robot, fresh, parameters, selection, seen)
    simulator = partial(replayer_of, case, config, apart=apart, windows=whole.segments)
    if nearer is not None and needed(case.robot, nearer):
        shorter = replace(unnamed, problem=shortened(case, config, whole), selection=nearer)
        found = yield from unknown_law_nearer(unnamed, shorter, simulator)
    else:
        found = (yield from unknown_law(unnamed, simulator)) if lacking else None
    if found is None and joint is not None:
        found = yield from single_term(replace(unnamed, problem=problem), joint, simulator)
    return found or (without_piles(case.robot, selection, nearer), problem)


def _by_shorter(
    case: Case, config: ExplainConfig, whole: Problem, named: _Named, parameters: Hypothesis
) -> Generator[Progress, None, tuple[Selection, Problem]]:
    """What shorter windows choose and find whole, where neither names nor a law explain the usual ones.

    Or where these show what explains them only in motions that part, and shorter ones show nothing.
    """
    selection, problem, nearer = named.selection, named.problem, named.nearer
    if selection.seen:
        return selection, problem
    explained = selection.chosen.error <= QUIET or any(map(is_law, selection.chosen.places))
    by_luck = not shows_unparted(problem, selection)
    if explained and not by_luck:
        return selection, problem
    if nearer is None and hangs_on_hairs(problem, selection, 0.0 if by_luck else QUIET):
        shorter = shortened(case, config, whole)
        nearer = Nearer(*(yield from select(shorter, parameters, config.most)))
    if nearer is None:
        return selection, problem
    nothing = nearer.selection.chosen.error <= NOISE and not nearer.selection.chosen.places
    believed = (by_luck and nothing) or (not explained and says_all(nearer.selection, selection))
    return nearer if believed else (selection, problem)


def _suffices(case: Case, selection: Selection, nearer: Selection) -> bool:
    """Whether shorter windows chose names that are the whole of what is wrong, and the usual ones took them over."""
    taken = selection.chosen.places == nearer.chosen.places != ()
    return taken and not needed(case.robot, nearer) and doubled(case.robot, nearer) is None


def _refitted(problem: Problem, selection: Selection) -> Generator[Progress, None, dict[str, Fit]]:
    """The chosen explanation, its part that MJCF can say, and its rivals, fitted to all training windows."""
    robot, chosen, parameters = problem.replayer.robot, selection.chosen.fitted, selection.parameters.fitted
    changes = chosen.hypothesis.changes(chosen.vector, claimed=True)
    said = [c for c in (c if expressible(robot, c) else tell.told_change(c) for c in changes) if expressible(robot, c)]
    sayable = claiming(problem.replayer.robot, parameters.hypothesis, [(c.effect, c.name or "") for c in said])
    known = {(f.effect, f.site, f.parameter): v for f, v in zip(chosen.hypothesis.free, chosen.vector, strict=True)}
    known |= {(c.effect, c.name or "", name): v for c in said for name, v in c.parameters.items()}
    start = np.array([known.get((f.effect, f.site, f.parameter), f.neutral) for f in sayable.free])
    wrong = placebo(problem.replayer.robot, parameters.hypothesis, selection)
    kinds = {"explained": (chosen.hypothesis, [chosen.vector]), "sayable": (sayable, [start])}
    kinds |= {"placebo": wrong} if wrong else {}
    tasks: dict[Hypothesis, Task] = {task[0]: task for task in reversed(kinds.values())}
    stage = "all training recordings"
    fits, _ = yield from fitted(problem, list(tasks.values()), stage, 20)
    by_hypothesis = {f.hypothesis: f for f in fits}
    there = about(problem, parameters).corrected([parameters.member])
    bent: list[Task] = [(parameters.hypothesis, [parameters.vector])]
    price, name = there.price_of(there.fitted), f"{stage}, parameters only"
    [own] = yield from fit(there, bent, there.fitted, price, stage=name, iterations=30)
    return {"parameters_only": own, **{kind: by_hypothesis[h] for kind, (h, _) in kinds.items()}}
