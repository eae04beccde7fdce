"""One planted case from its plan to its row of scores, and the rows of many."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from estexp_jax.runs import versions, write_json
from estexp_jax.runs.fleet import Beat
from experiments.concealed.generator.__main__ import write_one
from experiments.concealed.generator.case import Plan
from experiments.concealed.runner import ending_of, explain_case, findings_of
from experiments.concealed.scoring.judge import Row, Size, judge
from experiments.planted.planned import planned

PUBLISHED = Path(__file__).parent / "rows.json"
"""What is known of the reported set: a run goes on with it on any machine."""
ESTEXP = (sys.executable, "-m", "estexp_jax.cli.main", "explain", "--no-pictures")
"""What explains; it sees the recordings and the nominal model, nothing else."""


def numbered(seed: int, part: str) -> dict[str, Plan]:
    """The plans of a part of a set by their ids, which are those that they have in the whole."""
    wanted = {plan.seed for plan in planned(seed, part)}
    return {f"c{i:03d}": plan for i, plan in enumerate(planned(seed)) if plan.seed in wanted}


def entries_of(out: Path, seed: int) -> dict[str, dict[str, Any]]:
    """Rows of all cases that have been explained, here or in what is published of the same set, by their ids."""
    known = json.loads(PUBLISHED.read_text(encoding="utf-8")) if PUBLISHED.is_file() else {"seed": None}
    entries = known["rows"] if known["seed"] == seed else []
    entries += [json.loads(path.read_text(encoding="utf-8")) for path in (out / "rows").glob("c*.json")]
    return {entry["case"]: entry for entry in sorted(entries, key=lambda entry: entry["case"])}


def publish(entries: Mapping[str, Mapping[str, Any]], seed: int) -> None:
    """Keep rows beside the README."""
    write_json(PUBLISHED, {"seed": seed, "versions": versions(), "rows": list(entries.values())})


def row_of(entry: Mapping[str, Any]) -> Row:
    """A row as it was before it became JSON."""
    sizes = tuple(Size(**size) for size in entry["sizes"])
    known = {name: value for name, value in entry.items() if name != "commit"}
    return Row(**{**known, "sizes": sizes, "claimed": tuple(entry["claimed"])})


def explained(out: Path, case: str, plan: Plan, timeout: float, command: tuple[str, ...]) -> None:
    """Draw a case, explain it and judge the findings; of the recordings nothing is kept but for a failure.

    Args:
        out: folder of the set.
        case: its id.
        plan: what it is to be.
        timeout: most seconds that explaining it may take.
        command: what explains.
    """
    with Beat(out / "under_way", case) as beat:
        beat.tell(0.0, "drawing")
        answer = write_one(out, case, plan)
        beat.tell(0.2, "explaining")
        explain_case(out, case, timeout, command)
    ending, findings = ending_of(out, case), findings_of(out, case)
    if ending is None:
        raise KeyboardInterrupt
    wall = None if ending["resumed"] else ending["wall_s"]
    row = judge(case, answer, findings if ending["code"] == 0 else None, wall)
    (out / "rows").mkdir(exist_ok=True)
    write_json(out / "rows" / f"{case}.json", {**asdict(row), "commit": commit()})
    if ending["code"] == 0:
        shutil.rmtree(out / "cases" / case)


def commit() -> str | None:
    """The commit that is at work here; None where nobody can tell."""
    asked = ["git", "-C", str(Path(__file__).parent), "rev-parse", "HEAD"]
    done = subprocess.run(asked, capture_output=True, text=True, check=False)
    return done.stdout.strip() or None
