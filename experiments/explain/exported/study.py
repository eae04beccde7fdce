"""Every effect planted, found and exported: how far the corrected file and `explained.py` are off."""

from __future__ import annotations

import argparse
import json
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import estexp_jax as ee
from estexp_jax.runs import versions, write_json
from experiments.explain.exported.export_errors import changes_of, export_errors
from experiments.explain.exported.plans import Plan, planned
from experiments.explain.exported.robots import MODELS
from experiments.explain.exported.table import write_table
from experiments.harness.explain_runner import EXPLAIN, explain_case
from experiments.harness.rows import read_rows, write_rows
from experiments.harness.study import Study, words

_SECONDS, _RATE, _SEED = 4.0, 100.0, 1
_QUICK = ("command_delay.servo", "supply_sag.torque")


def main_of(study: Study, arguments: Sequence[str] | None) -> int:
    """Do what the command line asks; gives the exit code."""
    options = _parsed(study, words(arguments))
    plans = {name: plan for name, plan in planned().items() if not options.only or name in options.only}
    known = {row["case"]: row for row in _rows(options.out)}
    for i, (name, plan) in enumerate(plans.items()):
        print(f"{name}: {i + 1} of {len(plans)}", flush=True)
        wanted = (
            "given"
            if options.given and not (options.out / "explained" / name / "effects.json").is_file()
            else "explain"
        )
        if known.get(name, {}).get("by") != wanted:
            write_json(options.out / "rows" / f"{name}.json", _row(options.out, name, plan, options))
    rows = _rows(options.out)
    write_rows(options.out / "rows.parquet", rows, versions=versions())
    print(f"table: {write_table(options.out / 'table.md', rows)}")
    study.publish(options.out, options.publish)
    return 0


def _parsed(study: Study, arguments: Sequence[str]) -> argparse.Namespace:
    parser = study.parser(quick="two cases")
    parser.add_argument("--given", action="store_true", help="export what was planted, where nothing was explained yet")
    parser.add_argument("--only", nargs="+", default=None, metavar="CASE", help="names of cases")
    parser.add_argument("--step", type=float, default=None, help="of the models, s; the recordings' own is 0.001")
    parser.add_argument("--timeout", type=float, default=3600.0, help="most seconds an explanation may take")
    options = parser.parse_args(arguments)
    options.out = study.results(options.out, *([] if options.out else ["quick" if options.quick else "full"]))
    options.only = options.only or (_QUICK if options.quick else None)
    (options.out / "rows").mkdir(exist_ok=True)
    return options


def _rows(out: Path) -> list[dict[str, Any]]:
    found = [json.loads(path.read_text(encoding="utf-8")) for path in sorted((out / "rows").glob("*.json"))]
    return found or read_rows(out / "rows.parquet")


def _row(out: Path, name: str, plan: Plan, options: argparse.Namespace) -> dict[str, Any]:
    """Record a case, explain it, and measure what was written."""
    case, explained = out / "cases" / name, out / "explained" / name
    if not (case / "truth.json").is_file():
        model = out / "models" / f"{plan.robot}.xml"
        model.parent.mkdir(exist_ok=True)
        model.write_text(MODELS[plan.robot], encoding="utf-8")
        ee.record(model, case, effect=[plan.effect], duration=_SECONDS, rate=_RATE, seed=_SEED, force=True)
    if not options.given and not (explained / "effects.json").is_file():
        explain_case(out, name, options.timeout, (*EXPLAIN, "--no-pictures"))
    found = (explained / "effects.json").is_file()
    changes, finer = changes_of(explained if found else case)
    row: dict[str, Any] = {"case": name, "effect": plan.effect, "robot": plan.robot, "has_element": plan.has_element}
    row |= {"by": "explain" if found else "given", "claimed": _claimed(explained) if found else []}
    manifest = case / "recordings.toml"
    row |= export_errors(manifest, changes, options.step, finer)
    if found:
        shutil.rmtree(explained / "predictions", ignore_errors=True)
    return row


def _claimed(explained: Path) -> Sequence[str]:
    findings: Mapping[str, Any] = json.loads((explained / "findings.json").read_text(encoding="utf-8"))
    return [f"{entry['effect']}@{entry['name']}" if entry["name"] else entry["effect"] for entry in findings["what"]]
