"""The set of laws that the catalogue lacks."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from estexp_jax.discovery.law_findings import COVERED
from experiments.benchmark.baselines import oracle
from experiments.benchmark.baselines.logs import floor, gain, nrmse, read_case
from experiments.benchmark.generator.case import Plan
from experiments.benchmark.scoring.judge import axis
from experiments.explain.out_of_catalogue.forces import FORCES
from experiments.explain.out_of_catalogue.plans import PARTS, left_out, planned
from experiments.explain.out_of_catalogue.scores import write_scores
from experiments.harness.explain_study import ExplainStudy, numbered
from experiments.harness.study import Study

_POINTS = 400
"""So many samples of a law are kept for its figure."""


def _command(plan: Plan) -> tuple[str, ...]:
    return (
        sys.executable,
        "-m",
        "experiments.explain.out_of_catalogue.reduced_catalogue",
        "--without",
        ",".join(left_out(plan)),
    )


def _beside(out: Path, case: str, answer: Mapping[str, Any]) -> dict[str, Any]:
    """Gains on each test recording, of the explanation and of the true law, and how well the law's force is known."""
    forces = json.loads((out / "explained" / case / "laws.json").read_text(encoding="utf-8"))
    findings = json.loads((out / "explained" / case / "findings.json").read_text(encoding="utf-8"))
    model, logs = read_case(out / "cases" / case)
    tests = [log for log in logs if log.role == "test"]
    truths = oracle.errors(answer, model, logs)
    found = []
    for log, own, true in zip(tests, forces["tests"].values(), truths, strict=True):
        noise = floor([log])
        shares = gain(own["explained"], own["nominal"], noise), gain(true, nrmse(model, [log]), noise)
        found.append({"explained": shares[0], "true": shares[1]})
    return {"inside": found[0], "beyond": found[1], "force": force_error(findings, forces["laws"], answer)}


def force_error(
    findings: Mapping[str, Any], laws: list[dict[str, Any]], answer: Mapping[str, Any]
) -> dict[str, Any] | None:
    """How far the force found at the true joint is off, where both can be said by position, speed and motor torque.

    Named effects at the joint count with the law beside them.

    Returns:
        The root mean square of its error as a share of the true force's, in the range that is covered, and samples
        (q, w, true, found) for a figure; None where the law was not found there or has other arguments.
    """
    [effect] = answer["effects"]
    true, here = FORCES.get(effect["law"] or effect["effect"]), effect["axis"]
    law = next((law for law in laws if law["joint"] == here), None)
    if true is None or law is None:
        return None
    q, w, motor, total = (np.array(law[name]) for name in ("q", "w", "motor", "given"))
    for claim in findings["what"]:
        if claim["effect"] == "unknown_law" or axis(claim, answer) != here:
            continue
        if claim["effect"] not in FORCES:
            return None
        total = total + FORCES[claim["effect"]]({k: p["value"] for k, p in claim["parameters"].items()}, q, w, motor)
    felt = true(effect["parameters"], q, w, motor)
    (low, high), fast = np.quantile(q, COVERED), np.quantile(np.abs(w), COVERED[1])
    inside = (q >= low) & (q <= high) & (np.abs(w) <= fast)
    share = np.sqrt(np.mean((total - felt)[inside] ** 2) / np.mean(felt[inside] ** 2))
    some = np.linspace(0, len(q) - 1, min(_POINTS, len(q))).round().astype(int)
    samples = {
        name: np.round(x[some], 5).tolist() for name, x in (("q", q), ("w", w), ("true", felt), ("found", total))
    }
    return {"error": float(share), **samples}


def out_of_catalogue(script: str, about: str | None) -> ExplainStudy:
    """The study of a `run.py`."""
    study = Study.of(script, about)
    return ExplainStudy(
        study=study,
        planned=partial(numbered, planned),
        parts=PARTS,
        seed=20276,
        quick=(4001, "own"),
        published=study.folder / "rows.parquet",
        write_scores=write_scores,
        command=_command,
        beside=_beside,
    )
