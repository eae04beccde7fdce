"""Findings as text, for terminals and notebooks."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import Any

from estexp_jax.physics.effects.sites import ALL_ALIKE
from estexp_jax.physics.recording import HEALTHY
from estexp_jax.report.tables import html_table

VERDICTS = {
    "consistent": "The simulator agrees with the recordings, up to noise.",
    "parameters": "Values that the model already has are off; nothing is missing.",
    "missing_physics": "The simulator lacks physics.",
    "unexplained": "The simulator is wrong, and no effect of the catalogue explains how.",
}
"""Each verdict in a sentence."""
CHANGES = {
    "consistent": "Nothing has changed since the robot was healthy, up to noise.",
    "parameters": "Values of the model have changed since the robot was healthy; nothing else has.",
    "missing_physics": "The robot has changed since it was healthy.",
    "unexplained": "The robot has changed since it was healthy, and no effect of the catalogue explains how.",
}
"""Each verdict in a sentence, where recordings of the healthy robot were given."""


def place_name(kind: str, name: str | None) -> str:
    """`joint knee`; `all actuators` of all alike; `environment`."""
    if name is None:
        return kind
    return f"all {kind}s" if name == ALL_ALIKE else f"{kind} {name}"


def is_change(findings: Mapping[str, Any]) -> bool:
    """Whether it is told what changed since the robot was healthy."""
    return any(entry["role"] == HEALTHY for entry in findings["data"])


def verdict_sentence(findings: Mapping[str, Any]) -> str:
    """The verdict in a sentence."""
    return (CHANGES if is_change(findings) else VERDICTS)[findings["verdict"]]


def explain_summary(findings: Mapping[str, Any]) -> str:
    """The verdict, each claim with its numbers, the proof, and the alternatives; several lines."""
    lines = [verdict_sentence(findings)]
    lines += [f"  {claim(entry)}" for entry in findings["what"]]
    lines += [f"  When it was healthy: {claim(entry)}" for entry in findings.get("baseline", ())]
    lines += [proof(findings)]
    for other in findings["alternatives"]:
        if other["probability"] >= 0.05:
            effects = " + ".join(other["effects"]) or "parameters alone"
            lines.append(f"It could also be {effects} ({other['probability']:.0%}).")
    return "\n".join(lines)


def claim(entry: Mapping[str, Any]) -> str:
    """One effect: sentence, intervals, probability."""
    sentence = entry["sentence"][0].upper() + entry["sentence"][1:]
    equation = f": {entry['equation']}" if entry["effect"] == "unknown_law" else ""
    return f"{sentence}{equation} ({intervals(entry)}; probability {entry['probability']:.0%})."


def intervals(entry: Mapping[str, Any]) -> str:
    """`T = 1.02 (0.97 to 1.08) N m` for each parameter; `at least` where it is at its bound."""
    parts = []
    for name, p in entry["parameters"].items():
        within = _within(p["low"], p["high"])
        parts.append(f"{name} = {p['value']:.3g}{within} {p['unit']}".rstrip())
    return ", ".join(parts)


def _within(low: float | None, high: float | None) -> str:
    if low is None:
        return "" if high is None else f" (at most {high:.3g})"
    return f" (at least {low:.3g})" if high is None else f" ({low:.3g} to {high:.3g})"


def proof(findings: Mapping[str, Any]) -> str:
    """How much better the test recordings are predicted."""
    fit = findings["fit"]
    before, after, value = fit["nominal"]["test"], fit["explained"]["test"], fit["gain"]
    sentence = (
        f"On recordings not used for fitting the error is {after:.3g} instead of {before:.3g} of the sensors' range"
    )
    if value["value"] is None or value["value"] != value["value"]:
        return f"{sentence}."
    interval = f"90 % interval {value['low']:.0%} to {value['high']:.0%}"
    return f"{sentence}: {value['value']:.0%} of the excess is gone ({interval})."


def explain_rows(findings: Mapping[str, Any]) -> list[dict[str, Any]]:
    """One row for each parameter of each claim."""
    return [
        {"effect": entry["effect"], "at": entry["name"], "parameter": name, **p, "probability": entry["probability"]}
        for entry in findings["what"]
        for name, p in entry["parameters"].items()
    ]


def explain_table(findings: Mapping[str, Any]) -> str:
    """Verdict, a table of the claims, and proof; as HTML."""
    columns = ("effect", "at", "parameter", "value", "low", "high", "unit", "probability")
    rows = [[row[column] for column in columns] for row in explain_rows(findings)]
    table = html_table(columns, rows) if rows else ""
    return f"<p><b>{escape(verdict_sentence(findings))}</b></p>{table}<p>{escape(proof(findings))}</p>"
