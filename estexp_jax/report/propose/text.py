"""A proposed motion as text, for terminals, notebooks, `advice.md` and the report."""

from __future__ import annotations

from html import escape
from typing import Any

import numpy as np

from estexp_jax.discovery.competing_models import CompetingModel
from estexp_jax.discovery.findings import TOLD
from estexp_jax.experiment_design.propose import CLEAR_SEPARATION, LIMIT_TOLERANCE, ProposedExperiment
from estexp_jax.physics.model.robot import Robot
from estexp_jax.report.channels import unit_of
from estexp_jax.report.pages import probability
from estexp_jax.report.tables import html_table

_ELSE = "Wider limits (--speed, --margin), a motor switched off, a known load or another sensor may help."
_STILL = "Still record it: small differences add up over a recording. "


def column_of(robot: Robot, channel: str) -> str:
    """The name of a channel's column in a recording."""
    return f"sensor.{channel}" if channel in robot.sensor_columns() else channel


def propose_rows(proposed: ProposedExperiment) -> list[dict[str, Any]]:
    """One row for each pair of explanations: its separation, and the time and reading of the largest difference."""
    rows = zip(*np.triu_indices(len(proposed.competing_models.models), 1), strict=True)
    return [_pair_row(proposed, int(i), int(j)) for i, j in rows]


def _pair_row(proposed: ProposedExperiment, i: int, j: int) -> dict[str, Any]:
    channels, predicted = proposed.competing_models.channels, proposed.predicted
    difference = predicted.readings[j] - predicted.readings[i]
    share = np.abs(_in_deviations(proposed, difference))
    row, channel = np.unravel_index(int(np.argmax(share)), share.shape)
    return {
        "rival": i + 1,
        "other": j + 1,
        "separation": float(predicted.separation[i, j]),
        "random": float(proposed.random_separation[i, j]),
        "told_apart": bool(predicted.separation[i, j] >= CLEAR_SEPARATION),
        "sensor": channels[channel],
        "time": float(proposed.time[row]),
        "difference": float(difference[row, channel]),
        "unit": unit_of(proposed.robot, channels[channel]),
        "deviations": float(share[row, channel]),
    }


def _in_deviations(proposed: ProposedExperiment, readings: np.ndarray) -> np.ndarray:
    deviations = proposed.competing_models.deviations
    return readings / np.where(deviations > 0.0, deviations, np.inf)


def propose_summary(proposed: ProposedExperiment) -> str:
    """The explanations, and the separation of each pair under the motion; several lines."""
    explanations = enumerate(proposed.competing_models.models, start=1)
    lines = [open_summary(proposed), *(f"  {n}. {one.label} ({rival_status(one)})" for n, one in explanations)]
    lines += [propose_verdict(proposed)]
    for pair in propose_rows(proposed):
        separation = f"{pair['separation']:.3g} deviations apart, by random motions {pair['random']:.3g}"
        lines.append(f"  {pair['rival']} and {pair['other']}: {separation}; most at {largest_difference(pair)}")
    return "\n".join(lines)


def deviation_sentence() -> str:
    """What a deviation is, and from how many on a pair is plainly separated."""
    return (
        "One deviation is a reading's noise, or an ordinary error (3 %) of one value of the model, all the time. From"
        f" {CLEAR_SEPARATION:g} on, two explanations are plainly apart."
    )


def open_summary(proposed: ProposedExperiment) -> str:
    """How many explanations remain."""
    left = sum(rival.open for rival in proposed.competing_models.models[1:])
    if left:
        return f"Besides the chosen explanation (1), {left} {'is' if left == 1 else 'are'} possible:"
    return "The recordings support only the chosen explanation (1): no other has a probability of 1 %. The nearest:"


def rival_status(rival: CompetingModel) -> str:
    """The probability of an explanation, or why it has none."""
    if rival.probability >= TOLD:
        return f"probability {probability(rival.probability)}"
    return "fits as well, by more numbers" if rival.tied else "refuted already"


def propose_verdict(proposed: ProposedExperiment) -> str:
    """How many pairs of explanations the motion distinguishes."""
    pairs = propose_rows(proposed)
    faint = [pair for pair in pairs if not pair["told_apart"]]
    if not faint:
        least = min(pair["separation"] for pair in pairs)
        return f"The proposed motion tells them apart: any two differ by {least:.3g} deviations or more."
    still = _STILL if max(pair["separation"] for pair in faint) >= 1.0 else ""
    if len(faint) == len(pairs):
        sentence = f"none brings two of them {CLEAR_SEPARATION:g} deviations apart"
        return f"No motion found within the limits tells them plainly apart: {sentence}. {still}{_ELSE}"
    same = ", ".join(f"{pair['rival']} and {pair['other']}" for pair in faint)
    sentence = f"tells {len(pairs) - len(faint)} of {len(pairs)} pairs apart"
    return f"The proposed motion {sentence}; no motion found does so plainly for {same}. {still}{_ELSE}"


def largest_difference(pair: dict[str, Any]) -> str:
    """Time and reading of the largest difference of a pair."""
    size = f"{abs(pair['difference']):.3g} {pair['unit']}".rstrip()
    return f"{pair['time']:.2f} s, where `{pair['sensor']}` differs by {size} ({pair['deviations']:.3g} deviations)"


def propose_table(proposed: ProposedExperiment) -> str:
    """The explanations as a list and the pairs as a table; HTML."""
    rows = propose_rows(proposed)
    explanations = "".join(f"<li>{escape(r.label)} ({rival_status(r)})</li>" for r in proposed.competing_models.models)
    table = html_table(list(rows[0]), [list(row.values()) for row in rows])
    return f"<p><b>{escape(propose_verdict(proposed))}</b></p><ol>{explanations}</ol>{table}"


def motion_sentence(proposed: ProposedExperiment) -> str:
    """The contents of `commands.csv`, and its limits."""
    config = proposed.config
    rate = 1.0 / (proposed.time[1] - proposed.time[0])
    return (
        f"holds {proposed.time[-1]:.3g} s of commands at {rate:.4g} Hz. Start at home, at rest. They use"
        f" at most {config.margin:.0%} of each range of command and joint, or what the recordings used already; joints"
        f" move at most {config.speed:g} times as fast as in the recordings."
    )


def caution(proposed: ProposedExperiment) -> str:
    """A warning if a limit is exceeded; else empty."""
    if proposed.predicted.excess <= LIMIT_TOLERANCE:
        return ""
    beyond = f"goes {proposed.predicted.excess:.0%} beyond a limit of joint or speed, or brings parts together,"
    sentence = f"{beyond} under at least one explanation"
    return f"no motion found stays within the limits; this one {sentence}."


def command_ranges(proposed: ProposedExperiment) -> list[tuple[str, str, str]]:
    """Each actuator with its lowest and highest command."""
    pairs = zip(proposed.robot.command_columns(), proposed.commands.T, strict=True)
    return [(name, f"{column.min():.3g}", f"{column.max():.3g}") for name, column in pairs]


def distinguishing_readings(proposed: ProposedExperiment) -> list[dict[str, str]]:
    """For each explanation, the reading and time at which its prediction is farthest from the nearest other one."""
    return [_distinguishing_reading(proposed, n) for n in range(len(proposed.competing_models.models))]


def _distinguishing_reading(proposed: ProposedExperiment, n: int) -> dict[str, str]:
    readings, models = proposed.predicted.readings, proposed.competing_models
    scaled = _in_deviations(proposed, readings)
    others = np.delete(np.arange(len(models.models)), n)
    nearest = np.abs(scaled[others] - scaled[n]).min(axis=0)
    row, channel = np.unravel_index(int(np.argmax(nearest)), nearest.shape)
    name, values = models.channels[channel], readings[others, row, channel]
    unit, low, high = unit_of(proposed.robot, name), f"{values.min():.3g}", f"{values.max():.3g}"
    span = low if low == high else f"{low} to {high}"
    return {
        "number": f"{n + 1}",
        "time": f"{proposed.time[row]:.2f}",
        "sensor": name,
        "own": f"{readings[n, row, channel]:.3g} {unit}".rstrip(),
        "others": f"{span} {unit}".rstrip(),
        "label": models.models[n].label,
    }


def next_command(proposed: ProposedExperiment) -> str:
    """The command that explains again with the new recording."""
    train, test = (
        " ".join(n for n, r in proposed.competing_models.recordings if r == role) for role in ("train", "test")
    )
    return f"estexp explain MODEL.xml {train} proposed.csv --test {test} --out out/again"
