"""Finished runs of `recover` as rows, and what a study writes beside them."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from estexp_jax.physics.effects.changes import Change
from estexp_jax.runs import versions, write_json
from experiments.harness.diagnosis_score import amount_error, same_set, text
from experiments.harness.recovery_case import RecoveryCase
from experiments.harness.world import quadruped


def result(case: RecoveryCase, store: Path) -> dict[str, Any]:
    """The record of a finished run."""
    return json.loads((store / case.name / "run.json").read_text(encoding="utf-8"))


def row(case: RecoveryCase, store: Path) -> dict[str, Any]:
    """One run in a line: its distances, and of each pass whether the diagnosis was right."""
    found = result(case, store)
    planted = changes(found["planted"])
    line: dict[str, Any] = {**case.labels(), "planted": text(planted), **found["distance"]}
    for number, each in enumerate(found["passes"], start=1):
        diagnosis = changes(each["diagnosis"])
        line |= {
            f"trial_{number}": each["hardware_m"],
            f"right_{number}": same_set(planted, diagnosis),
            f"error_{number}": amount_error(quadruped(), planted, diagnosis),
            f"diagnosis_{number}": text(diagnosis),
        }
    return {**line, "wall_s": found["wall_s"]}


def changes(entries: Iterable[Mapping[str, Any]]) -> tuple[Change, ...]:
    """As in `run.json`."""
    return tuple(Change.from_json(entry) for entry in entries)


def write_summary(path: Path, summary: Mapping[str, Any], **about: Any) -> None:
    """Numbers, with the seeds, versions and machine they were got with."""
    write_json(path, {**about, **summary, "versions": versions()})
