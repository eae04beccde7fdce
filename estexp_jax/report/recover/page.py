"""The report of a recovery run as one HTML file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite, isnan
from typing import Any

import numpy as np

from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.effects.registry import effect
from estexp_jax.recovery.state import Pass, RunState
from estexp_jax.report.drawing.film import source
from estexp_jax.report.pages import capital, image, metres, percent, probability, render_page
from estexp_jax.report.recover.figure import path_figure, progress_figure
from estexp_jax.report.recover.film import Film

_RECOVERED, _PARTLY = 0.9, 0.5
"""Shares of the lost distance above which a robot has recovered, or has recovered in part."""
_LARGE_MISS = 0.25
"""Error of a predicted trial, as a share of the distance before the damage, above which it is reported."""


def recover_page(
    title: str,
    planted: Sequence[Change] | None,
    state: RunState,
    axis: str,
    settings: Mapping[str, Any],
    film: Film | None = None,
    *,
    stands_in: bool = False,
) -> str:
    """HTML of a run after the damage.

    Args:
        title: of the run.
        planted: the true damage; None: unknown.
        state: the run.
        axis: of the distance.
        settings: names to values, for the last section.
        film: pictures of the gaits; None: not drawn.
        stands_in: the values before the damage are the simulator's.
    """
    passes = state.passes(axis)
    last = passes[-1] if passes else None
    return render_page(
        "recover/page.html",
        title=title,
        verdict=recover_verdict(state, axis),
        headline=recover_headline(state, axis, stands_in),
        diagnosis=None if last is None else [_change_entry(change) for change in last.diagnosis],
        probability="" if last is None or last.probability is None else probability(last.probability),
        trials=len(state.trials) - 1,  # the last trial came after the last diagnosis
        alarm=last is not None and bool(last.alarm),
        known=planted is not None,
        planted=[change.sentence() for change in planted or ()],
        nothing="nothing was planted",
        progress=image(progress_figure(state, axis, stands_in=stands_in)),
        stands_in=stands_in,
        paths=image(path_figure(state, axis, stands_in=stands_in)) if _path_known(state) else None,
        rows=recover_rows(state, axis),
        others=[] if last is None else [_alternative(diagnosis, p) for diagnosis, p in last.alternatives],
        advice=recover_advice(state, axis),
        strip="" if film is None else source(film.strip, "image/jpeg"),
        video="" if film is None or film.video is None else source(film.video, "video/mp4"),
        settings=list(settings.items()),
    )


def recover_verdict(state: RunState, axis: str) -> str:
    """Whether the robot recovered."""
    share = _recovered_share(state, axis)
    if share is None:
        return "The robot is damaged." if state.trials else "The robot has not been damaged yet."
    if isnan(share):
        return "How far the robot walks is not known."
    if share == float("inf"):
        return "The damage cost the robot nothing."
    if share >= _RECOVERED:
        return "The robot walks again."
    return "The robot walks again, in part." if share >= _PARTLY else "The robot has not recovered."


def _recovered_share(state: RunState, axis: str) -> float | None:
    """Share of the lost distance that the last trial recovered.

    Infinite if none was lost, NaN if a distance is unknown, None before a trial.
    """
    if state.before is None or not state.trials[1:]:
        return None
    before, damaged, last = (trial.distance(axis) for trial in (state.before, state.trials[0], state.trials[-1]))
    if isnan(before + damaged + last):
        return float("nan")
    return (last - damaged) / (before - damaged) if before > damaged else float("inf")


def _path_known(state: RunState) -> bool:
    """Whether the damaged robot's path over the ground is known, not only the distance."""
    return any(np.all(np.isfinite(trial.position[[0, -1], :2])) for trial in (state.trials[0], state.trials[-1]))


def recover_headline(state: RunState, axis: str, stands_in: bool = False) -> str:
    """The run and what broke, in two sentences; `stands_in` as for `recover_page`."""
    if state.before is None:
        return "The robot has not been damaged yet."
    before, damaged = metres(state.before.distance(axis)), metres(state.trials[0].distance(axis))
    text = f"The robot walked {before} before the damage and {damaged} after it"
    if stands_in:
        text = f"The undamaged simulator walked {before}, the damaged robot {damaged}"
    if state.trials[1:]:
        whole, last = state.before.distance(axis), state.trials[-1].distance(axis)
        share = f", {percent(last / whole, 0)} of before" if isfinite(last / whole) and whole > 0.0 else ""
        text = f"{text}; its last trial covered {metres(last)}{share}"
    return f"{text}. {_found(state, axis)}".strip()


def _found(state: RunState, axis: str) -> str:
    """What broke, by the last diagnosis, in a sentence; nothing where there is none."""
    passes, trials = state.passes(axis), len(state.trials) - 1
    if not passes or not passes[-1].diagnosis:
        return ""
    broken = " and ".join(change.sentence() for change in passes[-1].diagnosis)
    return f"Found after {trials} trial{'s' if trials > 1 else ''}: {broken}."


def recover_rows(state: RunState, axis: str) -> list[dict[str, Any]]:
    """A row of texts for each pass."""
    return [
        {
            "number": number,
            "diagnosis": [change.sentence() for change in each.diagnosis],
            "probability": "" if each.probability is None else f"{each.probability:.2f}",
            "simulated": f"{each.simulated:.2f}",
            "hardware": f"{each.hardware:.2f}" if isfinite(each.hardware) else "–",
        }
        for number, each in enumerate(state.passes(axis), start=1)
    ]


def recover_advice(state: RunState, axis: str) -> list[str]:
    """Advice from the last pass."""
    passes = state.passes(axis)
    if not passes or state.before is None:
        return []
    last = passes[-1]
    gap = abs(last.simulated - last.hardware) / max(abs(state.before.distance(axis)), 1e-9)
    advice = []
    if last.alarm:
        advice.append(
            "Let the search use more effects (--catalogue full), or allow the simulator more error (--model-error)."
        )
    if gap > _LARGE_MISS:
        advice.append(
            f"The last trial missed the predicted distance by {percent(gap, 0)} of the distance before the damage. The "
            "simulator lacks more than the diagnosis; recordings of the robot and `estexp explain` can find it."
        )
    if last.alternatives:
        advice.append("More passes (--passes) give the search more trials to exclude the other diagnoses.")
    return advice + _search_advice(last, _recovered_share(state, axis))


def _search_advice(last: Pass, share: float | None) -> list[str]:
    if share is None or not share < _PARTLY or last.alarm:
        return []
    return ["A larger search (--generations, --population) may find a better gait for the diagnosed robot."]


def _change_entry(change: Change) -> dict[str, str]:
    return {"sentence": capital(change.sentence()), "equation": effect(change.effect).equation}


def _alternative(diagnosis: Sequence[Change], share: float) -> dict[str, str]:
    text = "; ".join(change.sentence() for change in diagnosis) or "nothing differs"
    return {"text": text, "probability": probability(share)}
