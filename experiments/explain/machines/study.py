"""The set of cases from real machines."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from experiments.explain.machines.cases import planned, write_case
from experiments.explain.machines.devices import DEVICES
from experiments.explain.machines.page import write_page
from experiments.harness.explain_runner import EXPLAIN, findings_of
from experiments.harness.explain_study import ExplainStudy
from experiments.harness.study import Study

_KEPT = ("verdict", "where", "what", "fit", "cost")
"""Of the findings, what stands in the published rows."""


def machines(script: str, about: str | None) -> ExplainStudy:
    """The study of a `run.py`; its seed decides nothing, as nothing is drawn."""
    study = Study.of(script, about)
    return ExplainStudy(
        study=study,
        planned=planned,
        parts=("all", "quick", *DEVICES),
        seed=1,
        quick=(2, "quick"),
        published=study.folder / "rows.parquet",
        write_scores=write_page,
        write_case=write_case,
        command=_command,
        beside=_beside,
        timeout_s=7200.0,
    )


def _command(_: object) -> tuple[str, ...]:
    return EXPLAIN


def _beside(out: Path, case: str, _: Mapping[str, Any]) -> dict[str, Any]:
    findings = findings_of(out, case)
    assert findings is not None
    return {"findings": {name: findings[name] for name in _KEPT}}
