"""`estexp experiment diagnosis`: how often a diagnosis is exactly right, on the same-simulator and the foreign robot.

estexp experiment diagnosis --quick                  few cases
estexp experiment diagnosis --workers 8              all 13 situations, 10 seeds, both robots, and the paper's search
python experiments/recover/diagnosis/run.py --seeds 5 --part foreign --part same
python experiments/recover/diagnosis/run.py --seeds 5 --report       tables and figures of what is finished
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

PARTS = ("same", "foreign", "paper", "alarm-same", "alarm-foreign")
"""Set search on either robot; the paper's search on the same one; the paper's catalogue, for the alarm."""
FIRST = {"same": 6000, "foreign": 7000}
"""First seeds: earlier ones were looked at before the last changes."""


def main(arguments: Sequence[str] | None = None) -> int:
    """All diagnoses, one file each; then the tables and figures of those that are there.

    What is published beside the README no machine does again.
    """
    from experiments.harness.options import parsed, publish
    from experiments.harness.runs import each

    given = list(sys.argv[1:] if arguments is None else arguments)
    parts = [given[i + 1] for i, word in enumerate(given) if word == "--part"]
    own = [w for i, w in enumerate(given) if w in ("--part", "--report") or (i and given[i - 1] == "--part")]
    rest = [word for word in given if word not in own]
    options = parsed("diagnosis", __doc__, seeds=10, quick_seeds=1, arguments=rest)
    asked, quick = [] if "--report" in given else parts or PARTS, options.size == "quick"
    tasks = [task for part in asked for task in tasks_of(part, options.n, quick=quick)]
    store, known = options.store.parent / "diagnoses", {} if quick else published()
    store.mkdir(parents=True, exist_ok=True)
    todo = [task for task in tasks if key(task) not in known and not _path(task, store).is_file()]
    each("diagnoses", [(_kept, task, store) for task in todo], options)
    everything = [task for part in PARTS for task in tasks_of(part, options.n, quick=quick)]
    report([row for task in everything for row in _rows(task, store, known)], options)
    publish(options, __file__)
    return 0


def tasks_of(part: str, n: int, *, quick: bool = False) -> list:
    """The tasks of a part, seed by seed."""
    from experiments.harness.recovery_case import seeds
    from experiments.recover.diagnosis.task import Task

    situations = (3, 9, 12) if quick else range(1, 14)
    robot = "same" if part in ("same", "paper", "alarm-same") else "foreign"
    catalogue, trials = "paper" if part.startswith("alarm") else "full", (1, 2) if robot == "same" else (4,)
    trials, drawn = (1, 2, 4) if part == "paper" else trials, seeds(n, FIRST[robot])
    return [Task(s, seed, robot, catalogue, part == "paper", trials) for seed in drawn for s in situations]


def key(task) -> tuple:
    """What tells a task from the others."""
    return task.robot, task.kind, task.situation, task.seed


def published() -> dict[tuple, list[dict[str, Any]]]:
    """Rows of the table beside the README, by their tasks' keys."""
    from experiments.harness.tables import read_rows

    found: dict[tuple, list[dict[str, Any]]] = {}
    for row in read_rows(Path(__file__).with_name("diagnoses.csv")):
        kind = "paper" if row["method"] == "paper" else f"set-{row['catalogue']}"
        found.setdefault((row["robot"], kind, row["situation"], row["seed"]), []).append(row)
    return found


def _path(task, store: Path) -> Path:
    return store / f"{task.robot}-{task.kind}-s{task.situation:02d}-{task.seed}.json"


def _rows(task, store: Path, known: dict[tuple, list[dict[str, Any]]]) -> list[dict[str, Any]]:
    import json

    path = _path(task, store)
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else known.get(key(task), [])


def _kept(task, store: Path) -> None:
    from estexp_jax.runs import write_json
    from experiments.recover.diagnosis.task import diagnose

    write_json(_path(task, store), diagnose(task))


def report(rows: Sequence[dict[str, Any]], options) -> None:
    """Tables, numbers and figures."""
    from experiments.harness.tables import write_rows, write_summary
    from experiments.recover.diagnosis.summary import draw, summary

    write_rows(options.out / "diagnoses.csv", rows)
    found = summary(rows)
    write_summary(options.out / "summary.json", found, seeds=sorted({row["seed"] for row in rows}))
    draw(found, rows, options.out)


if __name__ == "__main__":
    from experiments.harness.options import exit_code

    sys.exit(exit_code(main))
