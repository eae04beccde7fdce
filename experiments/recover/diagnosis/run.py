"""`estexp experiment diagnosis`: how often a diagnosis is exactly right, on the same-simulator and the foreign robot.

estexp experiment diagnosis --quick                  few cases
estexp experiment diagnosis --workers 8              all 13 situations, 10 seeds, both robots, and the paper's search
python experiments/recover/diagnosis/run.py --seeds 5 --part foreign same
python experiments/recover/diagnosis/run.py --seeds 5 --report       tables and figures of what is finished
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from experiments.harness.options import Options
    from experiments.recover.diagnosis.task import Task

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

PARTS = ("same", "foreign", "paper", "alarm-same", "alarm-foreign")
"""Set search on either robot; the paper's search on the same one; the paper's catalogue, for the alarm."""
FIRST = {"same": 6000, "foreign": 7000}
"""First seeds: earlier ones were looked at before the last changes."""


def main(arguments: Sequence[str] | None = None) -> int:
    """All diagnoses, one file each; then the tables and figures of those that are there.

    What is published beside the README no machine does again.
    """
    from experiments.harness.options import options_of, options_parser
    from experiments.harness.recovery_runs import each_kept, kept
    from experiments.harness.study import Study
    from experiments.recover.diagnosis.task import diagnose

    study = Study.of(__file__, __doc__)
    parser = options_parser(study, seeds=10)
    parser.add_argument("--part", nargs="+", choices=PARTS, default=PARTS, help="default: all")
    options = options_of(study, arguments, seeds=10, quick_seeds=1, parser=parser)
    store, known = options.store.parent / "diagnoses", {} if options.quick else published()
    if not options.report:
        asked = [task for part in options.given.part for task in tasks_of(part, options.n, quick=options.quick)]
        missing = [task for task in asked if key(task) not in known]
        each_kept("diagnoses", {_path(task, store): (diagnose, task) for task in missing}, options)
    everything = [task for part in PARTS for task in tasks_of(part, options.n, quick=options.quick)]
    report([row for task in everything for row in kept(_path(task, store)) or known.get(key(task), [])], options)
    study.publish(options.out, options.publish)
    return 0


def tasks_of(part: str, n: int, *, quick: bool = False) -> list[Task]:
    """The tasks of a part, seed by seed."""
    from experiments.harness.recovery_case import seeds
    from experiments.recover.diagnosis.task import Task

    situations = (3, 9, 12) if quick else range(1, 14)
    robot = "same" if part in ("same", "paper", "alarm-same") else "foreign"
    catalogue, trials = "paper" if part.startswith("alarm") else "full", (1, 2) if robot == "same" else (4,)
    trials, drawn = (1, 2, 4) if part == "paper" else trials, seeds(n, FIRST[robot])
    return [Task(s, seed, robot, catalogue, part == "paper", trials) for seed in drawn for s in situations]


def key(task: Task) -> tuple[str, str, int, int]:
    """What distinguishes a task from the others."""
    return task.robot, task.kind, task.situation, task.seed


def published() -> dict[tuple[str, str, int, int], list[dict[str, Any]]]:
    """Rows of the table beside the README, by their tasks' keys."""
    from experiments.harness.rows import read_rows

    found: dict[tuple[str, str, int, int], list[dict[str, Any]]] = {}
    for row in read_rows(Path(__file__).with_name("rows.parquet")):
        kind = "paper" if row["method"] == "paper" else f"set-{row['catalogue']}"
        found.setdefault((row["robot"], kind, row["situation"], row["seed"]), []).append(row)
    return found


def _path(task: Task, store: Path) -> Path:
    return store / f"{task.robot}-{task.kind}-s{task.situation:02d}-{task.seed}.json"


def report(rows: Sequence[dict[str, Any]], options: Options) -> None:
    """Tables, numbers and figures."""
    from experiments.harness.recovery_rows import write_summary
    from experiments.harness.rows import write_rows
    from experiments.recover.diagnosis.summary import draw, summary

    write_rows(options.out / "rows.parquet", rows)
    found = summary(rows)
    write_summary(options.out / "summary.json", found, seeds=sorted({row["seed"] for row in rows}))
    draw(found, rows, options.out)


if __name__ == "__main__":
    from experiments.harness.study import exit_code

    sys.exit(exit_code(main))
