"""`advice.md`: the open explanations, the motion to record, what to look for, and the next command."""

from __future__ import annotations

from estexp_jax.experiment_design.propose import ProposedExperiment
from estexp_jax.report.propose.text import (
    caution,
    command_ranges,
    deviation_sentence,
    distinguishing_readings,
    largest_difference,
    motion_sentence,
    next_command,
    open_summary,
    propose_rows,
    propose_verdict,
    rival_status,
)


def propose_advice(proposed: ProposedExperiment) -> str:
    """The text of `advice.md` (Markdown)."""
    parts = [
        f"# What to record next\n\n{propose_verdict(proposed)}",
        _explanations(proposed),
        _motion(proposed),
        _pairs(proposed),
        _readings(proposed),
        _next(proposed),
    ]
    return "\n\n".join(parts) + "\n"


def _explanations(proposed: ProposedExperiment) -> str:
    lines = [
        f"{n}. `{rival.label}` ({rival_status(rival)}): {rival.sentence}."
        for n, rival in enumerate(proposed.competing_models.models, start=1)
    ]
    return f"## Explanations\n\n{open_summary(proposed)}\n\n" + "\n".join(lines)


def _motion(proposed: ProposedExperiment) -> str:
    lines = [f"`commands.csv` {motion_sentence(proposed)}", "", "| actuator | lowest | highest |", "|---|---|---|"]
    lines += [f"| `{name}` | {low} | {high} |" for name, low, high in command_ranges(proposed)]
    if careful := caution(proposed):
        lines += ["", f"**Careful:** {careful}"]
    return "## The motion\n\n" + "\n".join(lines)


def _pairs(proposed: ProposedExperiment) -> str:
    lines = [
        deviation_sentence(),
        "",
        "| explanations | separation | by random motions | differ most |",
        "|---|---|---|---|",
    ]
    for pair in propose_rows(proposed):
        two = f"{pair['rival']} and {pair['other']}"
        lines.append(f"| {two} | {pair['separation']:.3g} | {pair['random']:.3g} | at {largest_difference(pair)} |")
    return "## Separation of the explanations, in deviations\n\n" + "\n".join(lines)


def _readings(proposed: ProposedExperiment) -> str:
    lines = [
        f"- If {s['number']} (`{s['label']}`) is right, `{s['sensor']}` reads {s['own']} at {s['time']} s, else"
        f" {s['others']} (`rivals/{s['number']}.csv`)."
        for s in distinguishing_readings(proposed)
    ]
    return "## What to look for\n\n" + "\n".join(lines)


def _next(proposed: ProposedExperiment) -> str:
    return (
        "## Next step\n\nPlay `commands.csv` on the robot and log it as before, for example as `proposed.csv`."
        f" Then explain again with that recording as training data:\n\n```sh\n{next_command(proposed)}\n```\n\n"
        'If a `recordings.toml` describes the logs, add `[[recording]]` with `file = "proposed.csv"` and'
        ' `role = "train"` to it instead.'
    )
