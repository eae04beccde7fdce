"""The set of planted cases."""

from __future__ import annotations

from functools import partial

from experiments.explain.planted.plans import PARTS, planned
from experiments.explain.planted.scores import write_scores
from experiments.harness.explain_study import ExplainStudy, numbered
from experiments.harness.study import Study


def planted(script: str, about: str | None) -> ExplainStudy:
    """The study of a `run.py`."""
    study = Study.of(script, about)
    return ExplainStudy(
        study=study,
        planned=partial(numbered, planned),
        parts=PARTS,
        seed=20261,
        quick=(4000, "two"),
        published=study.folder / "rows.parquet",
        write_scores=write_scores,
    )
