"""`mujoco.sysid` on every absorbed case of an opened set, where the baselines got those of a random 100 only.

python experiments/benchmark/run.py absorbed experiments/benchmark/opened/COMMIT/cases.parquet

The cases are drawn again, which the code that sealed them does best (`git worktree add FOLDER COMMIT`); each one's
recordings must have the hash that was kept. Result: `absorbed.parquet` beside the cases; what it holds stays.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from experiments.benchmark.baselines import sysid
from experiments.benchmark.baselines.all import NOTICED
from experiments.benchmark.baselines.logs import floor, gain, nrmse, read_case
from experiments.benchmark.generator import __main__ as writing
from experiments.benchmark.generator.case import Plan
from experiments.benchmark.scoring.comparison import is_absorbed
from experiments.benchmark.sealed import planned
from experiments.benchmark.sets import recordings_hash
from experiments.harness.rows import read_about, read_rows, write_rows
from experiments.harness.study import Study


def main(study: Study, arguments: Sequence[str]) -> int:
    """Do what is asked; gives the exit code."""
    form = argparse.RawTextHelpFormatter
    parser = argparse.ArgumentParser("benchmark absorbed", description=study.about, formatter_class=form)
    parser.add_argument("opened", type=Path, metavar="CASES", help="cases.parquet of an opened set of 420 cases")
    opened = parser.parse_args(arguments).opened
    if not opened.is_file():
        parser.error(f"{opened} is no file; opened sets are in experiments/benchmark/opened")
    if not sysid.available():
        print("absorbed: mujoco.sysid needs pip install 'mujoco[sysid]'", file=sys.stderr)
        return 2
    path, drawn = opened.with_name("absorbed.parquet"), planned(read_about(opened)["seed"], "all")
    done = {row["case"]: row for row in read_rows(path)}
    for row in read_rows(opened):
        case = row["case"]
        if case not in done and row.get("answer") and is_absorbed(row["answer"]):
            known = {name: row[name] for name in ("case", "robot", "truth", "detected", "gain")}
            done[case] = known | _asked(case, drawn[int(case[1:])], row["recordings_sha256"])
            write_rows(path, done.values())
            print(f"{case}: {done[case]}", flush=True)
    return 0


def _asked(case: str, plan: Plan, recordings: str) -> dict[str, Any]:
    """What sysid says of a case, unless its recordings are not those that were sealed."""
    with tempfile.TemporaryDirectory() as out:
        writing.write_one(Path(out), case, plan)
        folder = Path(out) / "cases" / case
        if recordings_hash(folder) != recordings:
            return {"same_recordings": False}
        model, logs = read_case(folder)
        found = sysid.run(folder, model, logs)
    trains, tests = ([log for log in logs if log.role == role] for role in ("train", "test"))
    return {
        "same_recordings": True,
        "sysid_noticed": bool(found["train"] > NOTICED * floor(trains)),
        "sysid_gain": gain(found["test"], nrmse(model, tests), floor(tests)),
        "sysid": found | {"floor_train": floor(trains)},
    }
