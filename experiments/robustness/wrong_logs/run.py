"""`estexp experiment wrong_logs`: does `check` name logs that are wrong in meaning, and let right ones pass?

estexp experiment wrong_logs --quick                               each kind once
python experiments/robustness/wrong_logs/run.py --each 2 --publish  each kind twice on three robots, as many right ones
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

SEED = 7_300_000
"""Seeds from here on are reported; settings were chosen on others."""


def main(arguments: Sequence[str] | None = None) -> int:
    """All logs, one after another; what is there already is kept."""
    from experiments.harness.study import Study, words
    from experiments.robustness.wrong_logs.kinds import KINDS
    from experiments.robustness.wrong_logs.robots import ROBOTS

    study = Study.of(__file__, __doc__)
    parser = study.parser(quick="each kind once, on one robot after another")
    parser.add_argument("--each", type=int, default=2, help="logs of each kind on each robot")
    parser.add_argument("--seed", type=int, default=SEED)
    given = parser.parse_args(words(arguments))
    out = study.results(given.out)
    names, number = list(ROBOTS), 0
    for round_ in range(1 if given.quick else given.each):
        for k, kind in enumerate(KINDS):
            for name in names[k % 3 :][:1] if given.quick else names:
                for wanted in (kind, ""):
                    _tried(out / "logs", name, wanted, given.seed + number, round_)
                    number += 1
    found = summary(out / "logs")
    (out / "summary.json").write_text(json.dumps(found, indent=1) + "\n")
    print(json.dumps(found, indent=1))
    study.publish(out, given.publish)
    return 0


def _tried(folder: Path, name: str, kind: str, seed: int, round_: int) -> None:
    kept = folder / f"{seed}.json"
    folder.mkdir(parents=True, exist_ok=True)
    if kept.is_file():
        return
    begin = time.process_time()
    faults, seconds = judged(name, kind, np.random.default_rng([seed, round_]))
    from experiments.robustness.wrong_logs.kinds import KINDS

    is_named = bool({f["kind"] for f in faults} & set(KINDS[kind].named)) if kind else not faults
    row = {"robot": name, "kind": kind, "seed": seed, "named": is_named, "check_s": seconds}
    row |= {"all_s": time.process_time() - begin, "faults": faults}
    kept.write_text(json.dumps(row, indent=1) + "\n")
    told = ", ".join(f"{f['kind']}@{f['name']}" for f in faults)
    print(f"{seed} {name}, {kind or 'right'}: {'yes' if is_named else 'NO'} ({told}), {seconds:.1f} s", flush=True)


def judged(name: str, kind: str, draw: np.random.Generator) -> tuple[list[dict[str, Any]], float]:
    """The faults that `check` tells of a log that is wrong in a way (empty: right), and its processor time, s."""
    from estexp_jax.recordings.bind import bind_columns
    from estexp_jax.recordings.inputs import Inputs
    from estexp_jax.recordings.table import Table
    from estexp_jax.report.check.result import check_inputs
    from experiments.robustness.wrong_logs.kinds import COPIED, KINDS
    from experiments.robustness.wrong_logs.robots import log_of, robot_of

    robot, columns = robot_of(name), log_of(name, draw)
    columns = KINDS[kind].make(columns, draw) if kind else columns
    recordings = [bind_columns(robot, Table("log.csv", columns), mend=True)]
    if kind == COPIED:
        recordings.append(bind_columns(robot, Table("test.csv", columns), role="test", mend=True))
    begin = time.process_time()
    result = check_inputs(Inputs(Path("robot.xml"), robot, tuple(recordings)))
    faults = [fault for one in result.recordings for fault in one["faults"]]
    return faults, (time.process_time() - begin) / len(recordings)


def summary(folder: Path) -> dict[str, Any]:
    """How many wrong logs were named by their kind, how many right ones had a warning, and the time that it took."""
    rows = [json.loads(path.read_text()) for path in sorted(folder.glob("*.json"))]
    wrong, right = [r for r in rows if r["kind"]], [r for r in rows if not r["kind"]]
    kinds = {kind: [r["named"] for r in wrong if r["kind"] == kind] for kind in dict.fromkeys(r["kind"] for r in wrong)}
    warned = [{"seed": r["seed"], "robot": r["robot"], "faults": r["faults"]} for r in right if not r["named"]]
    silent = [r["seed"] for r in wrong if not r["faults"]]
    return {
        "wrong": len(wrong),
        "named": sum(r["named"] for r in wrong),
        "nothing_said": len(silent),
        "right": len(right),
        "warned": len(warned),
        "check_s": {"median": _median(rows), "largest": max((r["check_s"] for r in rows), default=0.0)},
        "by_kind": {kind: f"{sum(named)} of {len(named)}" for kind, named in kinds.items()},
        "false_warnings": warned,
    }


def _median(rows: list[dict[str, Any]]) -> float:
    return float(np.median([r["check_s"] for r in rows])) if rows else 0.0


if __name__ == "__main__":
    from experiments.harness.study import exit_code

    sys.exit(exit_code(main))
