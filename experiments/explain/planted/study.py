"""The set of planted cases."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from experiments.benchmark.generator.case import Plan
from experiments.explain.planted.plans import PARTS, planned
from experiments.explain.planted.scores import write_scores
from experiments.harness.explain_study import CaseSet, row_of


def _command(_: Plan) -> tuple[str, ...]:
    return (sys.executable, "-m", "estexp_jax.cli.main", "explain", "--no-pictures")


def _scored(out: Path, entries: Sequence[Mapping[str, Any]], whole: int) -> Path:
    return write_scores(out, [row_of(entry) for entry in entries], whole)


PLANTED = CaseSet(
    name="planted",
    planned=planned,
    parts=PARTS,
    seed=20261,
    quick=(4000, "two"),
    published=Path(__file__).with_name("rows.json"),
    command=_command,
    write_scores=_scored,
)
