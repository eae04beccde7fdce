"""`estexp experiment diagnosis`: how often a diagnosis is exactly right, on the same-simulator and the foreign robot.

estexp experiment diagnosis --quick                  few cases
estexp experiment diagnosis --workers 8              all 13 situations, 10 seeds, both robots, and the paper's search
python experiments/diagnosis/run.py --seeds 5 --part foreign --part same
python experiments/diagnosis/run.py --seeds 5 --report       tables and figures of what is finished
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

PARTS = ("same", "foreign", "paper", "alarm-same", "alarm-foreign")
"""Set search on either robot; the paper's search on the same one; the paper's catalogue, for the alarm."""
FIRST = 6000
"""First seed: 5000 to 5004 were looked at while the last settings were chosen."""


def main(arguments: Sequence[str] | None = None) -> int:
    """All diagnoses, one file each; then the tables and figures of those that are there."""
    from experiments.common.options import parsed, publish
    from experiments.common.runs import each

    given = list(sys.argv[1:] if arguments is None else arguments)
    parts = [given[i + 1] for i, word in enumerate(given) if word == "--part"]
    own = [w for i, w in enumerate(given) if w in ("--part", "--report") or (i and given[i - 1] == "--part")]
    rest = [word for word in given if word not in own]
    options = parsed("diagnosis", __doc__, seeds=10, quick_seeds=1, arguments=rest)
    asked = [] if "--report" in given else parts or PARTS
    tasks = [task for part in asked for task in tasks_of(part, options.n, quick=options.size == "quick")]
    store = options.store.parent / "diagnoses"
    store.mkdir(parents=True, exist_ok=True)
    each("diagnoses", [(_kept, task, store) for task in tasks if not _path(task, store).is_file()], options)
    everything = [t for part in PARTS for t in tasks_of(part, options.n, quick=options.size == "quick")]
    report([task for task in everything if _path(task, store).is_file()], store, options)
    publish(options, __file__)
    return 0


def tasks_of(part: str, n: int, *, quick: bool = False) -> list:
    """The tasks of a part, seed by seed."""
    from experiments.common.case import seeds
    from experiments.diagnosis.task import Task

    situations = (3, 9, 12) if quick else range(1, 14)
    robot = "same" if part in ("same", "paper", "alarm-same") else "foreign"
    catalogue, trials = "paper" if part.startswith("alarm") else "full", (1, 2) if robot == "same" else (4,)
    trials, drawn = (1, 2, 4) if part == "paper" else trials, seeds(n, FIRST)
    return [Task(s, seed, robot, catalogue, part == "paper", trials) for seed in drawn for s in situations]


def _path(task, store: Path) -> Path:
    kind = "paper" if task.paper else f"set-{task.catalogue}"
    return store / f"{task.robot}-{kind}-s{task.situation:02d}-{task.seed}.json"


def _kept(task, store: Path) -> None:
    from estexp_jax.runs import write_json
    from experiments.diagnosis.task import diagnose

    write_json(_path(task, store), diagnose(task))


def report(tasks: Sequence, store: Path, options) -> None:
    """Tables, numbers and figures."""
    import json

    from experiments.common.tables import write_rows, write_summary
    from experiments.diagnosis.summary import draw, summary

    rows = [row for task in tasks for row in json.loads(_path(task, store).read_text(encoding="utf-8"))]
    write_rows(options.out / "diagnoses.csv", rows)
    found = summary(rows)
    write_summary(options.out / "summary.json", found, seeds=sorted({row["seed"] for row in rows}))
    draw(found, rows, options.out)


if __name__ == "__main__":
    from experiments.common.options import exit_code

    sys.exit(exit_code(main))
