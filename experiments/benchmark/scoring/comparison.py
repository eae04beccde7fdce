"""The explanation beside the baselines, and what refitted parameters absorb."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from experiments.benchmark.baselines.logs import gain
from experiments.benchmark.scoring.judge import Row

_QUIET, _VISIBLE = 1.2, 3.0
"""Floors that a refit of all parameters may leave in training recordings, and must leave in test recordings."""


def is_absorbed(answer: Mapping[str, Any]) -> bool:
    """Whether a refit explains the training recordings of a case with an effect, which its test recordings show."""
    refit = answer["visibility"]["refit"]
    return bool(answer["effects"]) and refit["train"] <= _QUIET and refit["test"] >= _VISIBLE


def absorbed(rows: Sequence[Row], answers: Mapping[str, Any], baselines: Mapping[str, Any]) -> dict[str, Any]:
    """Cases whose training recordings a refit of all parameters explains, though held-out ones show the effect."""
    answered = [r for r in rows if r.case in answers]  # the others failed
    inside = [r for r in answered if is_absorbed(answers[r.case])]
    noticed = [baselines[r.case]["sysid"]["noticed"] for r in inside if "sysid" in baselines.get(r.case, {})]
    return {
        "cases": len(inside),
        "noticed": sum(r.detected for r in inside),
        "sysid_asked": len(noticed),
        "sysid_noticed": sum(noticed),
    }


def beside(rows: Sequence[Row], baselines: Mapping[str, Any]) -> dict[str, Any]:
    """Median held-out gain of each baseline and of the explanation, on the visible cases where the baseline ran.

    Refitted parameters, the placebo and the black box (a small network trained on the residual force) come with every
    explanation; the others run by themselves.
    """
    pairs: dict[str, list[tuple[float, float]]] = {}
    for r in rows:
        theirs = {name: result.get("gain") for name, result in baselines.get(r.case, {}).items()}
        if r.floor is not None:
            errors = {n: e for n, e in r.errors.items() if n != "explained"}
            theirs |= {name: gain(error, r.errors["nominal"], r.floor) for name, error in errors.items()}
        for name, theirs_here in theirs.items():
            if r.visible and r.gain is not None and theirs_here is not None:
                pairs.setdefault(name, []).append((theirs_here, r.gain))
    found = {}
    for name, each in sorted(pairs.items()):
        other, own = np.median(each, axis=0).tolist()
        found[name] = {"cases": len(each), "gain": other, "explained": own}
    return found
