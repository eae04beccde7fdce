"""`mujoco.sysid` on every absorbed case of an opened set, where its rivals got those of a random 100 only.

The cases are drawn again by the code that sealed them; each one's recordings must have the hash that was kept:

git worktree add FOLDER 454bd59 && cp experiments/benchmark/absorbed.py FOLDER/experiments/benchmark/
python FOLDER/experiments/benchmark/absorbed.py experiments/benchmark/opened/454bd59/cases.json

Result: `absorbed.json` beside the cases. What it holds is not run again. All that is new stands in this one file, so
that it can be copied to a commit that knew nothing of it.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

_QUIET, _SEEN = 1.2, 3.0
"""Floors that a refit of all parameters may leave in training recordings, and must leave in test recordings."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Do what is asked; gives the exit code."""
    from experiments.benchmark.baselines import sysid
    from experiments.benchmark.generator.plans import plans
    from experiments.benchmark.sealed import CASES
    from experiments.benchmark.sets import SEALED

    parser = argparse.ArgumentParser("absorbed", description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("opened", type=Path, metavar="CASES", help="cases.json of an opened set of 420 cases")
    opened = parser.parse_args(arguments).opened
    if not opened.is_file():
        parser.error(f"{opened} is no file; opened sets are in experiments/benchmark/opened")
    if not sysid.available():
        print("absorbed: mujoco.sysid needs pip install 'mujoco[sysid]'", file=sys.stderr)
        return 2
    known, path = json.loads(opened.read_text(encoding="utf-8")), opened.with_name("absorbed.json")
    done = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    drawn = {f"c{i:03d}": plan for i, plan in enumerate(plans(known["seed"], CASES, SEALED))}
    for row in known["rows"]:
        if row["case"] not in done and "answer" in row and is_absorbed(row["answer"]):
            done[row["case"]] = {n: row[n] for n in ("robot", "truth", "detected", "gain")} | _asked(
                row["case"], drawn[row["case"]], row["recordings_sha256"]
            )
            path.write_text(json.dumps(done, indent=1) + "\n", encoding="utf-8")
            print(f"{row['case']}: {done[row['case']]}", flush=True)
    return 0


def is_absorbed(answer: Mapping[str, Any]) -> bool:
    """Whether a refit explains the training recordings of a case with an effect, which its test recordings show."""
    refit = answer["visibility"]["refit"]
    return bool(answer["effects"]) and refit["train"] <= _QUIET and refit["test"] >= _SEEN


def _asked(case: str, plan: Any, recordings: str) -> dict[str, Any]:
    """What sysid says of a case, unless its recordings are not those that were sealed."""
    from experiments.benchmark.baselines import sysid
    from experiments.benchmark.baselines.all import NOTICED
    from experiments.benchmark.baselines.logs import floor, gain, nrmse, read_case
    from experiments.benchmark.generator.__main__ import write_one
    from experiments.benchmark.sets import recordings_hash

    with tempfile.TemporaryDirectory() as out:
        write_one(Path(out), case, plan)
        folder = Path(out) / "cases" / case
        if recordings_hash(folder) != recordings:
            return {"same_recordings": False}
        model, logs = read_case(folder)
        told = sysid.run(folder, model, logs)
    trains, tests = ([log for log in logs if log.role == role] for role in ("train", "test"))
    return {
        "same_recordings": True,
        "sysid_noticed": bool(told["train"] > NOTICED * floor(trains)),
        "sysid_gain": gain(told["test"], nrmse(model, tests), floor(tests)),
        "sysid": told | {"floor_train": floor(trains)},
    }


if __name__ == "__main__":
    sys.exit(main())
