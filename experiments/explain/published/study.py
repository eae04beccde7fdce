"""The set of machines: each folder's recordings as its manifest has them, or as the study of machines maps them."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from experiments.explain.machines.cases import MachineCase, cases, data_folder, write
from experiments.explain.machines.score import answer_of
from experiments.explain.published.board import write_board
from experiments.explain.published.values import MACHINES
from experiments.harness.explain_runner import EXPLAIN, findings_of
from experiments.harness.explain_study import ExplainStudy
from experiments.harness.study import Study

_KEPT = ("verdict", "what", "fit", "cost")
"""Of the findings, what stands in the published rows."""
_QUICK = ("emps", "hls_angle")
Planned = Path | MachineCase
"""A folder with a manifest, or a case of the study of machines."""


def published(script: str, about: str | None) -> ExplainStudy:
    """The study of a `run.py`; its seed decides nothing, as nothing is drawn."""
    study = Study.of(script, about)
    return ExplainStudy(
        study=study,
        planned=planned,
        parts=("all", "quick", *MACHINES),
        seed=1,
        quick=(2, "quick"),
        published=study.folder / "rows.parquet",
        write_scores=write_board,
        write_case=write_case,
        command=lambda _: EXPLAIN,
        beside=_beside,
        timeout_s=3600.0,
    )


def planned(_: int, part: str) -> dict[str, Planned]:
    """The machines of a part that the data allow."""
    data, found = data_folder(), dict[str, Planned]()
    bases = {c.device.name: c for c in reversed(cases(data, quick=False).values()) if not c.base}
    for name in _QUICK if part == "quick" else MACHINES if part == "all" else (part,):
        if (data / name / "recordings.toml").is_file():
            found[name] = data / name
        elif name in bases:
            found[name] = bases[name]
    return found


def write_case(out: Path, name: str, case: Planned) -> Mapping[str, Any]:
    """Write `out/cases/<name>/`; gives the answer, which names nothing: the board has the values."""
    folder = out / "cases" / name
    if not (folder / "recordings.toml").is_file():
        if isinstance(case, Path):
            shutil.copytree(case, folder, dirs_exist_ok=True)
        else:
            write(case, data_folder(), folder)
    return answer_of(None, name)


def _beside(out: Path, case: str, _: Mapping[str, Any]) -> dict[str, Any]:
    findings = findings_of(out, case)
    assert findings is not None
    return {"findings": {name: findings[name] for name in _KEPT}}
