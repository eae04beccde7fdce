"""`estexp experiment next_trial`: trials until a diagnosis is right, each next one drawn, farthest or most telling.

estexp experiment next_trial --quick                 few cases
estexp experiment next_trial --workers 8             10 seeds, the foreign robot
python experiments/recover/next_trial/run.py --part diagnosis          walkers of the library, drawn or most telling
python experiments/recover/next_trial/run.py --part loop --size small --seeds 3     the whole loop, farthest or most telling
python experiments/recover/next_trial/run.py --size small --report     tables and figure of what is finished
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

PARTS = ("diagnosis", "loop")
SITUATIONS = tuple(range(1, 11))
"""Those of the paper that its catalogue can say."""
TRIALS = (1, 2, 3, 4)


def main(arguments: Sequence[str] | None = None) -> int:
    """All diagnoses and runs, then the tables and the figure of those that are there.

    Diagnoses that are published beside the README no machine does again.
    """
    from experiments.harness.options import parsed, publish
    from experiments.harness.runs import each, run_all

    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--part", choices=PARTS)
    parser.add_argument("--report", action="store_true")
    own, rest = parser.parse_known_args(sys.argv[1:] if arguments is None else list(arguments))
    options = parsed("next_trial", __doc__, seeds=10, quick_seeds=1, arguments=rest)
    parts = [] if own.report else [own.part] if own.part else PARTS
    situations = (3, 8) if options.size == "quick" else SITUATIONS
    tasks, cases = tasks_of(situations, options.n), cases_of(situations, options.size, options.n)
    store = options.store.parent / "next_trial_diagnoses"
    store.mkdir(parents=True, exist_ok=True)
    known = {} if options.size == "quick" else published()
    if "diagnosis" in parts:
        todo = [task for task in tasks if not (_path(task, store).is_file() or _key(task) in known)]
        each("diagnoses", [(_kept, task, store) for task in todo], options)
    if "loop" in parts:
        run_all(cases, options)
    report(_diagnoses(tasks, store, known), _runs(cases, options.store), options)
    publish(options, __file__)
    return 0


def tasks_of(situations: Sequence[int], n: int) -> list:
    """Diagnoses from walkers of the library, seed by seed, both ways to come to the next one."""
    from experiments.harness.recovery_case import seeds
    from experiments.recover.diagnosis.run import FIRST
    from experiments.recover.diagnosis.task import Task

    return [
        Task(s, seed, "foreign", trials=TRIALS, telling=telling)
        for seed in seeds(n, FIRST["foreign"])
        for s in situations
        for telling in (False, True)
    ]


def cases_of(situations: Sequence[int], size, n: int) -> list:
    """Whole runs, seed by seed."""
    from experiments.harness.recovery_case import Case, seeds

    ways = ("farthest", "telling")
    return [Case(s, i, size, "set", robot="foreign", next_trial=w) for i in seeds(n) for s in situations for w in ways]


def _path(task, store: Path) -> Path:
    return store / f"{_way(task)}-s{task.situation:02d}-{task.seed}.json"


def _way(task) -> str:
    return "telling" if task.telling else "drawn"


def _kept(task, store: Path) -> None:
    from estexp_jax.runs import write_json
    from experiments.recover.diagnosis.task import diagnose

    write_json(_path(task, store), diagnose(task))


def _key(task) -> tuple:
    return _way(task), task.situation, task.seed


def published() -> dict[tuple, list[dict[str, Any]]]:
    """Rows of diagnoses in the table beside the README, by their tasks' keys."""
    from experiments.harness.tables import read_rows

    found: dict[tuple, list[dict[str, Any]]] = {}
    for row in read_rows(Path(__file__).with_name("next_trial.csv")):
        if row["part"] == "diagnosis":
            found.setdefault((row["next_trial"], row["situation"], row["seed"]), []).append(row)
    return found


def _diagnoses(tasks: Sequence, store: Path, known: dict[tuple, list[dict[str, Any]]]) -> list[dict[str, Any]]:
    """A row for each number of trials of each task that is done."""
    import json

    found = []
    for task in tasks:
        path = _path(task, store)
        rows = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else known.get(_key(task), [])
        found += [{"part": "diagnosis", "next_trial": _way(task), **{n: row[n] for n in _NAMES}} for row in rows]
    return found


def _runs(cases: Sequence, store: Path) -> list[dict[str, Any]]:
    """A row for each diagnosis of each run that is done."""
    from experiments.harness.runs import finished
    from experiments.harness.tables import row

    found = []
    for case in (c for c in cases if finished(c, store)):
        line = row(case, store)
        for i in range(1, case.settings.passes + 1):
            own = {"trials": i, "right": line[f"right_{i}"], "diagnosis": line[f"diagnosis_{i}"]}
            about = {"part": "loop", "next_trial": case.next_trial, "situation": case.situation, "seed": case.seed}
            found.append({**about, **own, "planted": line["planted"], "distance": line[f"trial_{i}"]})
    return found


_NAMES = ("situation", "seed", "trials", "right", "error", "probability", "planted", "diagnosis")


def report(diagnoses: Sequence[dict[str, Any]], runs: Sequence[dict[str, Any]], options) -> None:
    """Tables, numbers and figure."""
    from experiments.harness.tables import write_rows, write_summary
    from experiments.recover.next_trial.summary import draw, summary

    rows = [*diagnoses, *runs]
    write_rows(options.out / "next_trial.csv", rows)
    write_summary(options.out / "summary.json", summary(rows), size_of_runs=options.size)
    draw(rows, options.out)


if __name__ == "__main__":
    from experiments.harness.options import exit_code

    sys.exit(exit_code(main))
