"""The set of arms with several effects, and with none."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from experiments.explain.several.cases import write_case
from experiments.explain.several.plans import PARTS, planned
from experiments.explain.several.scores import write_scores
from experiments.harness.explain_runner import findings_of
from experiments.harness.explain_study import ExplainStudy
from experiments.harness.study import Study

_KEPT = ("verdict", "where", "what", "fit", "cost")
"""Of the findings, what stands in the published rows."""
_ASKED = ("plan", "effects", "equivalents", "axes", "flaw", "known", "noise")
"""Of the answer."""


def several(script: str, about: str | None) -> ExplainStudy:
    """The study of a `run.py`."""
    study = Study.of(script, about)
    return ExplainStudy(
        study=study,
        planned=planned,
        parts=PARTS,
        seed=20264,
        quick=(4001, "first"),
        published=study.folder / "rows.parquet",
        write_scores=write_scores,
        write_case=write_case,
        beside=beside,
    )


def beside(out: Path, case: str, answer: Mapping[str, Any]) -> dict[str, Any]:
    """What was found and what is true, of which the scores are made."""
    findings = findings_of(out, case)
    assert findings is not None
    return {"findings": {k: findings[k] for k in _KEPT}, "answer": {k: answer[k] for k in _ASKED}}
