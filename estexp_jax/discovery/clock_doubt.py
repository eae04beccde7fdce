"""What is found in recordings whose clocks do not agree, which alone can look like any physics."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from estexp_jax.physics.recording import Recording

MOST_PROBABLE = 0.5
"""Highest probability of a claim that clocks or test recordings do not bear out: even odds. Convention."""


def clock_lines(recordings: Sequence[Recording]) -> list[str]:
    """A sentence on each fault of the recordings' clocks, with its remedy; none where they agree."""
    return [f"The clocks of {each.name} do not agree: {fault}." for each in recordings for fault in each.clock_faults]


def clocks_doubted(findings: Mapping[str, Any], recordings: Sequence[Recording]) -> dict[str, Any]:
    """Findings in which wrong clocks come first, and no physics is probable beside them.

    Args:
        findings: with `what`, `alternatives` and `advice`.
        recordings: those that were explained.
    """
    lines = clock_lines(recordings)
    if not lines:
        return dict(findings)
    what = [{**entry, "sentence": f"{entry['sentence']}, if the clocks are not to blame"} for entry in findings["what"]]
    claims = {"what": what, "alternatives": findings["alternatives"]}
    lowered = {
        key: [{**entry, "probability": _lowered(entry["probability"])} for entry in entries]
        for key, entries in claims.items()
    }
    return {**findings, **lowered, "advice": [*lines, *findings["advice"]]}


def _lowered(probability: float | None) -> float | None:
    """None where nothing can be said of it."""
    return None if probability is None else min(probability, MOST_PROBABLE)
