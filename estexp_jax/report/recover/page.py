"""The report of a recovery run: one HTML file that needs nothing else."""

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
"""Shares of what the damage cost from which on a robot has recovered, or in part."""
_BELIED = 0.25
"""Share of the distance before the damage by which a trial may miss the prediction."""


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
    """HTML of a run that has had its damage.

    Args:
        title: of the run.
        planted: what was wrong; None where nobody knows.
        state: the run.
        axis: of the distance.
        settings: names to values, for the record.
        film: how it walks, where it could be drawn.
        stands_in: what is told of the robot before the damage is the simulator's.
    """
    passes = state.passes(axis)
    last = passes[-1] if passes else None
    return render_page(
        "recover_page.html",
        title=title,
        verdict=recover_verdict(state, axis),
        headline=recover_headline(state, axis, stands_in),
        found=None if last is None else [_claim(change) for change in last.diagnosis],
        probability="" if last is None or last.probability is None else probability(last.probability),
        trials=len(state.trials) - 1,  # the last trial came after the last diagnosis
        alarm=last is not None and bool(last.alarm),
        known=planted is not None,
        planted=[change.sentence() for change in planted or ()],
        nothing="nothing was planted",
        progress=image(progress_figure(state, axis, stands_in=stands_in)),
        stands_in=stands_in,
        paths=image(path_figure(state, axis, stands_in=stands_in)) if _way_known(state) else None,
        rows=table(state, axis),
        others=[] if last is None else [_other(diagnosis, p) for diagnosis, p in last.alternatives],
        advice=recover_advice(state, axis),
        strip="" if film is None else source(film.strip, "image/jpeg"),
        video="" if film is None or film.video is None else source(film.video, "video/mp4"),
        settings=list(settings.items()),
    )


def recover_verdict(state: RunState, axis: str) -> str:
    """Whether the robot recovered."""
    regained = _regained(state, axis)
    if regained is None:
        return "The robot is damaged." if state.trials else "The robot has not been damaged yet."
    if isnan(regained):
        return "How far the robot walks is not known."
    if regained == float("inf"):
        return "The damage cost the robot nothing."
    if regained >= _RECOVERED:
        return "The robot walks again."
    return "The robot walks again, in part." if regained >= _PARTLY else "The robot has not recovered."


def _regained(state: RunState, axis: str) -> float | None:
    """Share of the distance lost that the last trial won back.

    Infinite where none was lost, NaN where a distance is not known, None before a trial.
    """
    if state.before is None or not state.trials[1:]:
        return None
    before, damaged, last = (trial.distance(axis) for trial in (state.before, state.trials[0], state.trials[-1]))
    if isnan(before + damaged + last):
        return float("nan")
    return (last - damaged) / (before - damaged) if before > damaged else float("inf")


def _way_known(state: RunState) -> bool:
    """Whether more is known of the damaged robot's way over the ground than how far it came."""
    return any(np.all(np.isfinite(trial.position[[0, -1], :2])) for trial in (state.trials[0], state.trials[-1]))


def recover_headline(state: RunState, axis: str, stands_in: bool = False) -> str:
    """The run in one sentence; `stands_in` as for `recover_page`."""
    if state.before is None:
        return "The robot has not been damaged yet."
    before, damaged = metres(state.before.distance(axis)), metres(state.trials[0].distance(axis))
    text = f"The robot walked {before} before the damage and {damaged} after it"
    if stands_in:
        text = f"The undamaged simulator walked {before}, the damaged robot {damaged}"
    return f"{text}; its last trial came {metres(state.trials[-1].distance(axis))}." if state.trials[1:] else f"{text}."


def table(state: RunState, axis: str) -> list[dict[str, Any]]:
    """A row for each pass, as texts."""
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
    """What to do next, as far as the last pass shows it."""
    passes = state.passes(axis)
    if not passes or state.before is None:
        return []
    last = passes[-1]
    gap = abs(last.simulated - last.hardware) / max(abs(state.before.distance(axis)), 1e-9)
    told = []
    if last.alarm:
        told.append(
            "Let the search choose from more (--catalogue full), or allow the simulator more error (--model-error)."
        )
    if gap > _BELIED:
        told.append(
            f"The last trial missed the predicted distance by {percent(gap, 0)} of the distance before the damage: the "
            "simulator lacks more than the diagnosis. Recordings of the robot and `estexp explain` show what."
        )
    if last.alternatives:
        told.append("More passes (--passes) give the search more trials to exclude the other diagnoses by.")
    return told + _more(last, _regained(state, axis))


def _more(last: Pass, regained: float | None) -> list[str]:
    if regained is None or not regained < _PARTLY or last.alarm:
        return []
    return ["A larger search (--generations, --population) may find a better gait for the robot as diagnosed."]


def _claim(change: Change) -> dict[str, str]:
    return {"sentence": capital(change.sentence()), "equation": effect(change.effect).equation}


def _other(diagnosis: Sequence[Change], share: float) -> dict[str, str]:
    text = "; ".join(change.sentence() for change in diagnosis) or "nothing differs"
    return {"text": text, "probability": probability(share)}
