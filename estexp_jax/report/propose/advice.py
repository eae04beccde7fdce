"""`propose_advice.md`: what is open, what to record, what to look for, how to go on."""

from __future__ import annotations

from estexp_jax.experiment_design.propose import CLEAR_SEPARATION, ProposedExperiment
from estexp_jax.report.propose.text import (
    again,
    caution,
    motion_sentence,
    opening,
    propose_rows,
    propose_verdict,
    reaches,
    signs,
    standing,
    time_of,
)


def propose_advice(proposed: ProposedExperiment) -> str:
    """`propose_advice.md`: what is open, what to record, what to look for, how to go on."""
    parts = [
        f"# What to record next\n\n{propose_verdict(proposed)}",
        _rivals(proposed),
        _motion(proposed),
        _pairs(proposed),
        _signs(proposed),
        _next(proposed),
    ]
    return "\n\n".join(parts) + "\n"


def _rivals(proposed: ProposedExperiment) -> str:
    lines = [
        f"{n}. `{rival.label}` ({standing(rival)}): {rival.sentence}."
        for n, rival in enumerate(proposed.competing_models.models, start=1)
    ]
    return f"## Explanations\n\n{opening(proposed)}\n\n" + "\n".join(lines)


def _motion(proposed: ProposedExperiment) -> str:
    lines = [f"`commands.csv` {motion_sentence(proposed)}", "", "| actuator | lowest | highest |", "|---|---|---|"]
    lines += [f"| `{name}` | {low} | {high} |" for name, low, high in reaches(proposed)]
    if careful := caution(proposed):
        lines += ["", f"**Careful:** {careful}"]
    return "## The motion\n\n" + "\n".join(lines)


def _pairs(proposed: ProposedExperiment) -> str:
    lines = [
        "One deviation is a reading's noise, or an ordinary error (3 %) of one value of the model, all the time. From"
        f" {CLEAR_SEPARATION:g} on, two explanations are plainly apart.",
        "",
        "| explanations | apart | by random motions | differ most |",
        "|---|---|---|---|",
    ]
    for pair in propose_rows(proposed):
        two = f"{pair['rival']} and {pair['other']}"
        lines.append(f"| {two} | {pair['separation']:.3g} | {pair['random']:.3g} | at {time_of(pair)} |")
    return "## How far apart they are, in deviations\n\n" + "\n".join(lines)


def _signs(proposed: ProposedExperiment) -> str:
    lines = [
        f"- If {s['number']} (`{s['label']}`) is right, at {s['time']} s `{s['sensor']}` reads {s['own']}, else"
        f" {s['others']} (`rivals/{s['number']}.csv`)."
        for s in signs(proposed)
    ]
    return "## What to look for\n\n" + "\n".join(lines)


def _next(proposed: ProposedExperiment) -> str:
    return (
        "## Then\n\nPlay `commands.csv` on the robot, log it as before, say as `proposed.csv`, and explain again with"
        f" that recording among those to learn from:\n\n```sh\n{again(proposed)}\n```\n\n"
        'Where a `recordings.toml` describes the logs, add `[[recording]]` with `file = "proposed.csv"` and'
        ' `role = "train"` to it instead.'
    )
