"""Results of finished runs as rows, and rows as files."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from estexp_jax.physics.changes import Change
from estexp_jax.runs import versions, write_json, write_text
from estexp_jax.runs.files import replacing
from experiments.harness.diagnosis_score import amount_error, same_set, text
from experiments.harness.recovery_case import Case
from experiments.harness.world import quadruped


def result(case: Case, store: Path) -> dict[str, Any]:
    """The record of a finished run."""
    return json.loads((store / case.name / "run.json").read_text(encoding="utf-8"))


def row(case: Case, store: Path) -> dict[str, Any]:
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


def write_rows(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """A CSV; numbers to four decimals."""
    columns, stream = list(dict.fromkeys(name for r in rows for name in r)), io.StringIO(newline="")
    writer = csv.DictWriter(stream, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows({k: round(v, 4) if isinstance(v, float) else v for k, v in r.items()} for r in rows)
    write_text(path, stream.getvalue())


def read_rows(path: Path) -> list[dict[str, Any]]:
    """Rows that `write_rows` wrote, numbers and truth values as they were; none without a file."""
    if not path.is_file():
        return []
    with path.open(encoding="utf-8", newline="") as file:
        return [{name: _value(text) for name, text in line.items()} for line in csv.DictReader(file)]


def _value(text: str) -> Any:
    known = {"": None, "True": True, "False": False}
    if text in known:
        return known[text]
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def write_figure(path: Path, figure: Any, dpi: int = 110) -> None:
    """A picture, whole or not at all; its extension decides the format."""
    with replacing(path) as stream:
        figure.savefig(stream, format=path.suffix.removeprefix("."), dpi=dpi)


def write_summary(path: Path, summary: Mapping[str, Any], **about: Any) -> None:
    """Numbers, with the seeds, versions and machine they were got with."""
    write_json(path, {**about, **summary, "versions": versions()})
