"""All that was found, told: the verdict, and the findings in the words of `findings.json`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np

from estexp_jax.discovery import findings as tell
from estexp_jax.discovery.competing_models import competing_models_of
from estexp_jax.discovery.confirmation import doubted
from estexp_jax.discovery.diagnosis import Case, Diagnosis, ExplainConfig, NativeModel
from estexp_jax.discovery.export import explained_spec, is_plain_value
from estexp_jax.discovery.fitting import FAR
from estexp_jax.discovery.force_residual import ForceResidual, force_residuals
from estexp_jax.discovery.intervals import parameter_intervals
from estexp_jax.discovery.law_findings import law_advice, law_entries
from estexp_jax.discovery.law_forces import LawForces, law_forces
from estexp_jax.discovery.law_plausibility import is_law
from estexp_jax.discovery.location import where
from estexp_jax.discovery.merged_claims import merged_claims
from estexp_jax.discovery.native_model import native_model
from estexp_jax.discovery.predictions import predictions_of
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.rivals import RIVALS, better, fit_entry, refuted
from estexp_jax.discovery.selection import Selection, probabilities, worth
from estexp_jax.discovery.shown import NOMINAL, Shown, shown_by
from estexp_jax.discovery.slopes import Fit
from estexp_jax.discovery.time_step_check import Step, step_of, to_blame
from estexp_jax.discovery.verdict import bent_values, verdict
from estexp_jax.discovery.when import never, when
from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.effects.written import mjcf_refusal
from estexp_jax.physics.engines.mjx.native import mjx_refusal


@final
@dataclass(frozen=True, eq=False)
class Found:
    """All that was found in a case, before it is told.

    Attributes:
        problem: the comparison about the chosen explanation.
        shown: the comparison as the results show it: nothing taken out of anything.
        selection: what was tried and chosen.
        fits: nominal, explained, sayable and rivals, fitted to all training windows.
        learned: errors of the black box.
        seen: what the joints of the robot with refitted parameters lack, in each training recording.
        own_step: whether the explained simulator is the nominal one, at the nominal step.
        intervals: (n_free, 2) of the explained fit's values, where they are known already.
    """

    problem: Problem
    shown: Problem
    selection: Selection
    fits: Mapping[str, Fit]
    learned: Mapping[str, float]
    seen: Sequence[ForceResidual]
    own_step: bool = False
    intervals: np.ndarray | None = None

    @property
    def claimed(self) -> tuple[Change, ...]:
        """The claims of the explained simulator, with their values."""
        final = self.fits["explained"]
        return final.hypothesis.changes(final.vector, claimed=True)


def diagnosis(case: Case, config: ExplainConfig, found: Found) -> Diagnosis:
    """What was found in a case, judged on the test recordings and told.

    Args:
        case: what was explained.
        config: how.
        found: everything.
    """
    judged, found, step = judged_by(case, found)
    shown = _shown(found)
    if judged == "unexplained" and needless(case, found, shown):
        found = _handing_over(found, "parameters_only")
        shown = _shown(found)
    # Shorter windows may have chosen what those that are shown refute. Training recordings alone decide.
    refused = found.claimed and not found.selection.seen and refuted(case, config, shown, "train")
    if refused or (judged == "unexplained" and not better(case, config, shown)):
        judged, found = "unexplained", _unchanged(found)
        shown = _shown(found)
    final, engine = found.fits["explained"], found.problem.replayer.choice
    changes, shares = _at_work(final), probabilities(found.selection, config.seed)
    native = _native(case, config, found, judged, changes, fine_only=step is not None)
    told = _told(case, config, found, shown, judged, step, shares)
    told["fit"]["mjcf"] = dict(native.errors)
    body = {
        "schema": "estexp.findings/1",
        "verdict": judged,
        **doubted(told, case.recordings),
        "baseline": [],
        "engine": {"name": engine.engine, "largest_difference": engine.largest_difference},
        "data": tell.data_entries(case.recordings),
        "cost": {"wall_s": None, "compile_s": None, "robot_steps": found.problem.counted[0]},
        "seed": config.seed,
        "versions": {},
    }
    return Diagnosis(
        case,
        config,
        body,
        found.selection,
        changes=changes,
        native=native,
        predictions=predictions_of(case, shown),
        finer=1 if found.own_step else found.shown.replays.cut.parts,
        rivals_finer=found.shown.replays.cut.parts,
        competing_models=competing_models_of(found.problem, found.selection, shares, changes),
        laws=_laws(case, found),
    )


def _native(
    case: Case, config: ExplainConfig, found: Found, judged: str, changes: Sequence[Change], *, fine_only: bool
) -> NativeModel:
    """What `model_explained.xml` holds: claims, or values of the model where these are what is told."""
    finer = 1 if found.own_step else found.shown.replays.cut.parts
    beside = [] if judged == "parameters" else [c for c in changes if c not in found.claimed]
    told = [*case.standing, *(c for c in changes if c not in beside)]
    refitted = (*case.standing, *_at_work(found.fits["sayable"]))
    how: dict[str, Any] = {"finer": finer, "fine_only": fine_only, "seed": config.seed}
    how["refusal"] = mjx_refusal if config.for_mjx else mjcf_refusal
    return native_model(case, found.shown, told, beside, refitted, **how)


def _shown(found: Found) -> Shown:
    """The fits that are compared, in all windows."""
    stepped = (NOMINAL, "explained") if found.own_step else (NOMINAL,)
    return shown_by(found.shown, {name: f for name, f in found.fits.items() if name in RIVALS}, stepped)


def needless(case: Case, found: Found, shown: Shown) -> bool:
    """Whether there are claims, and refitted values predict the training recordings as well without them."""
    train = shown.problem.windows_of(case.indices("train"))
    return bool(found.claimed) and shown.error("parameters_only", train) <= shown.error("explained", train)


def _unchanged(found: Found) -> Found:
    """The same with the nominal simulator as it is for an explained one, at a finer step only where that pays."""
    own_step = not worth(found.selection.corrected, found.selection.nominal)
    return replace(_handing_over(found, NOMINAL), own_step=own_step)


def _handing_over(found: Found, name: str) -> Found:
    """The same with the fit of a rival that claims nothing for the explained simulator."""
    kept = {rival: found.fits[rival] for rival in (NOMINAL, "parameters_only")}
    fits = kept | dict.fromkeys(("explained", "sayable"), found.fits[name])
    return replace(found, fits=fits, intervals=None)


def _laws(case: Case, found: Found) -> tuple[LawForces, ...]:
    """What unknown laws do along the training recordings, beside what their joints lack without them."""
    if not (terms := [c for c in found.claimed if is_law((c.effect, c.name or ""))]):
        return ()
    others = [c for c in _at_work(found.fits["explained"]) if c not in terms and is_plain_value(case.robot, c)]
    known = {id(robot): explained_spec(robot, others).compile() for robot in case.robots}
    seen = force_residuals(found.shown, [known[id(robot)] for robot in case.robots], case.indices("train"))
    joints = dict.fromkeys(str(c.name) for c in terms)
    return tuple(law_forces(case.robot, seen, j, [c for c in terms if c.name == j]) for j in joints)


def judged_by(case: Case, found: Found) -> tuple[str, Found, Step | None]:
    """The verdict, the fits that go with it, and the time step where that is to blame."""
    selection = found.selection
    judged = verdict(case.robot, selection, found.claimed)
    if judged == "parameters" and found.shown.replays.began:  # no value of the model changes meanwhile
        return "missing_physics", found, None
    as_it_is = min(selection.nominal, selection.corrected, key=lambda e: e.error)
    # Then nothing is changed, nor is anything bent that would predict no better, or that is far from what happens.
    closer = worth(selection.chosen, as_it_is) and selection.chosen.error <= FAR
    if judged == "consistent" or (judged == "unexplained" and not closer):
        return judged, _unchanged(found), None
    if judged != "parameters" or found.claimed:
        return judged, found, None
    error = found.shown.error(found.fits["nominal"].member, found.shown.trained)
    step = step_of(found.problem, found.fits["parameters_only"])
    return ("missing_physics", found, step) if to_blame(step, selection, error) else (judged, found, None)


def _told(
    case: Case,
    config: ExplainConfig,
    found: Found,
    shown: Shown,
    judged: str,
    step: Step | None,
    shares: np.ndarray,
) -> dict[str, Any]:
    """The entries of the findings that depend on what was found."""
    selection, wrong = found.selection, judged != "consistent"
    timestep = float(case.robot.model.opt.timestep)
    named, what = ((), [step.entry()]) if step else _what(case, found, judged, shares)
    places = [] if not wrong else [step.place()] if step else where(case.robot, selection)
    began = found.shown.replays.began
    errors = fit_entry(case, config, shown, list(shown.readings), found.learned)
    test, exact = found.shown.windows_of(case.indices("test")), found.shown.exact()

    def test_errors(fits: Sequence[Fit]) -> list[float]:
        simulated = exact.simulated([f.member for f in fits], test) if fits else []
        return [exact.recorded.error_of(x, test) for x in simulated]

    return {
        "side": "numerics" if step else tell.side(named),
        "where": places,
        "when": never(case) if step or not wrong else when(case, found.seen, places, began, config.seed),
        "what": what,
        "alternatives": tell.alternatives(selection, shares, test_errors),
        "fit": errors,
        "advice": (tell.belied(found.claimed) if refuted(case, config, shown, "test") else [])
        + tell.advice(judged, found.claimed, case.recordings, shares)
        + tell.noise_advice(found.problem)
        + tell.step_advice(selection, timestep)
        + tell.engine_advice(found.shown.replayer)
        + tell.black_box_advice(judged, errors)
        + law_advice(what),
    }


def _what(case: Case, found: Found, judged: str, shares: np.ndarray) -> tuple[tuple[Change, ...], list[dict[str, Any]]]:
    """The changes that are told, and their entries: claims, or values of the model by how far they are off."""
    final, claimed = found.fits["explained"], found.claimed
    if judged in ("consistent", "unexplained"):
        return (), []
    intervals = found.intervals if found.intervals is not None else parameter_intervals(found.problem, final)
    terms = tuple(c for c in claimed if is_law((c.effect, c.name or "")))
    named = tuple(c for c in claimed if c not in terms)
    bent = bent_values(case.robot, final, intervals) if judged == "parameters" else ()
    shown = [(c, tell.presence(found.selection, shares, c)) for c in named] + [(c, 1.0) for c in bent]
    entries = merged_claims(case.robot, [tell.what_entry(case.robot, c, final, intervals, p) for c, p in shown])
    laws = law_entries(
        case.robot, found.seen, (final, intervals), [(c, tell.presence(found.selection, shares, c)) for c in terms]
    )
    if claimed[:1] == terms[:1]:
        return (*terms, *named, *bent), laws + entries
    return (*named, *bent, *terms), entries + laws


def _at_work(fitted: Fit) -> tuple[Change, ...]:
    """The changes of a fit, without those that change nothing."""
    off = {(f.effect, f.site) for f, v in zip(fitted.hypothesis.free, fitted.vector, strict=True) if v != f.neutral}
    return tuple(c for c in fitted.hypothesis.changes(fitted.vector) if (c.effect, c.name or "") in off)
