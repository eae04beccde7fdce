"""The table of exported effects."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from estexp_jax.runs import write_text

FILE, SCRIPT = 1.2, 1.05
"""How many times the findings' own error the file may have, and `explained.py`."""
Row = Mapping[str, Any]
_COLUMNS = (
    *("case", "found", "nominal", "findings", "at the model's step", "file", "file / findings"),
    *("at the same step", "file / nominal", "explained.py / findings", "over the file"),
)
_RATIOS = (
    *(("file", "found"), ("file", "found_at_step"), ("file", "nominal")),
    *(("script", "found"), ("file_and_script", "found_at_step")),
)


def write_table(path: Path, rows: Sequence[Row]) -> Path:
    """Write all rows, and what is counted of them, as Markdown; gives the path."""
    lines = [*_counted(rows), "", f"| {' | '.join(_COLUMNS)} |", f"|{'---|' * len(_COLUMNS)}"]
    for row in sorted(rows, key=lambda r: (effect_of(r), r["robot"])):
        kinds = ("nominal", "found", "found_at_step", "file")
        errors = ["diverges" if row[name] is None else f"{row[name]:.5f}" for name in kinds]
        ratios = [f"{_ratio(row, *pair):.2f}" for pair in _RATIOS]
        claimed = ", ".join(row["claimed"]) if row["by"] == "explain" else "(given)"
        case = f"{row['effect']}, {row['robot']}"
        lines.append(f"| {' | '.join([case, claimed, *errors, *ratios])} |")
    write_text(path, "\n".join(lines) + "\n")
    return path


def effect_of(row: Row) -> str:
    """Name of a row's effect."""
    return row["effect"].partition("@")[0].partition(" ")[0]


def _ratio(errors: Row, name: str, of: str) -> float:
    """How many times an error is another one; one that is no number is endless."""
    one, other = (math.inf if errors[each] is None else errors[each] for each in (name, of))
    return one / max(other, 1e-12) if one < math.inf else math.inf


def _counted(rows: Sequence[Row]) -> list[str]:
    native = [r for r in rows if r["has_element"]]
    effects = {effect_of(r) for r in native}
    good = [r for r in native if _ratio(r, "file", "found_at_step") <= FILE]
    bad = {effect_of(r) for r in native if r not in good}
    scripted = [r for r in rows if _ratio(r, "script", "found") <= SCRIPT]
    over_file = [r for r in rows if _ratio(r, "file_and_script", "found_at_step") <= SCRIPT]
    explained = [r for r in rows if r["by"] == "explain"]
    right = [r for r in explained if r["effect"].partition(" ")[0] in r["claimed"]]
    return [
        f"- {len(rows)} cases; {len(explained)} explained, of which {len(right)} name the effect at its place; "
        "in the others what was planted is exported.",
        f"- The file alone, where MuJoCo has an element: {len(good)} of {len(native)} cases within {FILE} times the "
        f"findings' error at the same step; {len(effects - bad)} of {len(effects)} effects on all their robots.",
        f"- explained.py over the nominal model: {len(scripted)} of {len(rows)} within {SCRIPT} times; over the file, "
        f"at the file's step: {len(over_file)} of {len(rows)}.",
    ]
