"""All baselines on a random part of a set; what is done is kept in `out/baselines.json`, so a killed run goes on."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from experiments.benchmark.baselines import oracle, sparse, sysid
from experiments.benchmark.baselines.logs import Log, floor, gain, nrmse, read_case
from experiments.benchmark.sets import open_answers

NOTICED = 3.0
"""A parameter tool notices that something is wrong where its fit leaves so many floors in training."""


def run_baselines(out: Path, most: int | None = None) -> None:
    """Run what has not been run.

    Args:
        out: folder of a set.
        most: on so many cases, drawn by the set's seed; None: all.
    """
    answers, path = open_answers(out), out / "baselines.json"
    seed = json.loads((out / "commitment.json").read_text(encoding="utf-8"))["seed"]
    cases = sorted(answers)
    if most is not None and most < len(cases):
        cases = sorted(np.random.default_rng([seed, 9]).choice(cases, most, replace=False).tolist())
    done = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    if not sysid.available():
        print("mujoco.sysid is left out: it needs pip install 'mujoco[sysid]'", file=sys.stderr)
    for case in cases:
        if case not in done:
            done[case] = baselines_of(out / "cases" / case, answers[case])
            path.write_text(json.dumps(done, indent=1), encoding="utf-8")
            print(f"{case}: baselines {', '.join(done[case])}", flush=True)


def baselines_of(folder: Path, answer: Mapping[str, Any]) -> dict[str, Any]:
    """All baselines on one case, each with errors, gain and time; a failure is reported as one."""
    model, logs = read_case(folder)
    tests, trains = ([log for log in logs if log.role == role] for role in ("test", "train"))
    noise, nominal = floor(tests), nrmse(model, tests)
    found: dict[str, Any] = {"nominal": {"test": nominal, "train": nrmse(model, trains), "floor": noise, "gain": 0.0}}
    jobs: dict[str, Callable[[], dict[str, Any] | None]] = {"sparse": lambda: sparse.run(model, logs)}
    if sysid.available():
        jobs["sysid"] = lambda: _sysid(folder, model, logs, floor(trains))
    if "plan" in answer:
        jobs["oracle"] = lambda: {"test": oracle.error(answer, model, logs)}
    for name, job in jobs.items():
        begin = time.monotonic()
        result: dict[str, Any] | None
        try:
            result = job()
        except (ValueError, FloatingPointError, np.linalg.LinAlgError) as error:
            result = {"failed": str(error)}
        if result is not None:
            error = result.get("test")
            share = None if error is None else gain(error, nominal, noise)
            found[name] = result | {"gain": share, "wall_s": time.monotonic() - begin}
    return found


def _sysid(folder: Path, model: Any, logs: list[Log], noise: float) -> dict[str, Any]:
    result = sysid.run(folder, model, logs)
    return result | {"noticed": bool(result["train"] > NOTICED * noise)}
