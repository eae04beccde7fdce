"""What `check` found, in tables and sentences."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from estexp_jax.recordings.checks.excitation import SUSPECTS, missing
from estexp_jax.report.tables import TextTable

Judged = Sequence[Mapping[str, Any]]
"""What `recordings.checks.inspect.judge` says of each recording; at least one."""


def check_tables(judged: Judged) -> list[TextTable]:
    """Recordings, joints and commands."""
    clocks = ("file", "role", "rows", "s", "Hz", "jitter, ms", "gaps")
    joints = ("joint", "measured by", "largest span", "moves in", "can tell apart")
    commands = ("actuator", "low", "high", "saturated", "motor on")
    return [
        TextTable("Recordings", clocks, _recordings(judged)),
        TextTable("Joints", joints, _joints(judged)),
        TextTable("Commands", commands, _commands(judged)),
    ]


def check_sentences(judged: Judged) -> list[str]:
    """Remarks with the files that they are about, and what to record next."""
    sentences = []
    for remark, files in _remarks(judged).items():
        where = "all recordings" if len(files) == len(judged) > 1 else ", ".join(files)
        sentences.append(f"{where}: {remark}")
    advice = [f"to record: {sentence}" for sentence in missing(list(judged))]
    if not advice and not any(one["faults"] for one in judged):
        advice.append("Nothing looks wrong, and the motions can tell the usual suspects apart.")
    return sentences + advice


def _remarks(judged: Judged) -> dict[str, list[str]]:
    """Each remark, and the files that it is about."""
    remarks: dict[str, list[str]] = {}
    for one in judged:
        for remark in [*one["notes"], *one["suspicions"]]:
            remarks.setdefault(remark, []).append(one["file"])
    return remarks


def _recordings(judged: Judged) -> list[tuple[str, ...]]:
    rows = []
    for one in judged:
        clock = one["clock"]
        times = (f"{one['duration_s']:.4g}", f"{clock['hz']:.4g}", f"{1e3 * clock['jitter_s']:.3g}")
        clock_gaps = f"{clock['gaps']} (longest {clock['longest_s']:.3g} s)" if clock["gaps"] else "none"
        rows.append((one["file"], one["role"], str(one["rows"]), *times, clock_gaps))
    return rows


def _joints(judged: Judged) -> list[tuple[str, ...]]:
    rows = []
    for name in judged[0]["joints"]:
        found = [one["joints"][name] for one in judged]
        columns = dict.fromkeys(column for joint in found for column in joint["columns"])
        span = max((joint["span"] for joint in found if joint["span"] is not None), default=None)
        moves = sum(joint["excited"] is True for joint in found)
        moving = f"{moves} of {len(found)}" if columns else "unknown"
        able = [s.replace("_", " ") for s in SUSPECTS if any(joint["tells"].get(s) for joint in found)]
        motion = "-" if span is None else f"{span:.4g}", moving, ", ".join(able) or "nothing yet"
        rows.append((name, ", ".join(columns) or "nothing", *motion))
    return rows


def _commands(judged: Judged) -> list[tuple[str, ...]]:
    return [(name, *_command([one["commands"][name] for one in judged])) for name in judged[0]["commands"]]


def _command(found: Sequence[Mapping[str, Any]]) -> tuple[str, ...]:
    low, high = min(command["low"] for command in found), max(command["high"] for command in found)
    saturated = max((command["saturated"] for command in found if command["saturated"] is not None), default=None)
    worst = "no limit" if saturated is None else f"up to {saturated:.1%}"
    return f"{low:.4g}", f"{high:.4g}", worst, f"{min(command['enabled'] for command in found):.0%} at least"
