"""`estexp experiment next_trial`: trials until a diagnosis is right, each next one drawn, farthest or most informative.

estexp experiment next_trial --quick                 few cases
estexp experiment next_trial --workers 8             10 seeds, the foreign robot
python experiments/recover/next_trial/run.py --part diagnosis       walkers of the library, drawn or most informative
python experiments/recover/next_trial/run.py --part loop --size small --seeds 3     the whole loop
python experiments/recover/next_trial/run.py --size small --report     tables and figure of what is finished
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from estexp_jax.recovery.config import NextTrial
    from experiments.harness.options import Options
    from experiments.harness.recovery_case import RecoveryCase, Size
    from experiments.recover.diagnosis.task import Task

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

PARTS = ("diagnosis", "loop")
SITUATIONS = tuple(range(1, 11))
"""Those of the paper that its catalogue can say."""
TRIALS = (1, 2, 3, 4)
LOOP: dict[str, NextTrial] = {"farthest": "farthest", "informative": "informative"}
"""Ways to choose the next trial of the whole loop, and what `estexp recover --next-trial` calls them."""
_COLUMNS = ("situation", "seed", "trials", "right", "error", "probability", "planted", "diagnosis")


def main(arguments: Sequence[str] | None = None) -> int:
    """All diagnoses and runs, then the tables and the figure of those that are there.

    Diagnoses that are published beside the README no machine does again.
    """
    from experiments.harness.options import options_of, options_parser
    from experiments.harness.recovery_runs import each_kept, kept, run_cases
    from experiments.harness.study import Study
    from experiments.recover.diagnosis.task import diagnose

    study = Study.of(__file__, __doc__)
    parser = options_parser(study, seeds=10)
    parser.add_argument("--part", nargs="+", choices=PARTS, default=PARTS, help="default: both")
    options = options_of(study, arguments, seeds=10, quick_seeds=1, parser=parser)
    situations = (3, 8) if options.quick else SITUATIONS
    tasks, cases = tasks_of(situations, options.n), cases_of(situations, options.size, options.n)
    store = options.store.parent / "next_trial_diagnoses"
    known = {} if options.quick else published()
    if "diagnosis" in options.given.part and not options.report:
        missing = {_path(task, store): (diagnose, task) for task in tasks if _key(task) not in known}
        each_kept("diagnoses", missing, options)
    if "loop" in options.given.part and not options.report:
        run_cases(cases, options)
    diagnoses = [_labelled(task, r) for task in tasks for r in kept(_path(task, store)) or known.get(_key(task), [])]
    report(diagnoses, _runs(cases, options.store), options)
    study.publish(options.out, options.publish)
    return 0


def tasks_of(situations: Sequence[int], n: int) -> list[Task]:
    """Diagnoses from walkers of the library, seed by seed, both ways to come to the next one."""
    from experiments.harness.recovery_case import seeds
    from experiments.recover.diagnosis.run import FIRST
    from experiments.recover.diagnosis.task import Task

    return [
        Task(s, seed, "foreign", trials=TRIALS, informative=informative)
        for seed in seeds(n, FIRST["foreign"])
        for s in situations
        for informative in (False, True)
    ]


def cases_of(situations: Sequence[int], size: Size, n: int) -> list[RecoveryCase]:
    """Whole runs, seed by seed."""
    from experiments.harness.recovery_case import RecoveryCase, seeds

    return [
        RecoveryCase(s, seed, size, "set", robot="foreign", next_trial=way)
        for seed in seeds(n)
        for s in situations
        for way in LOOP.values()
    ]


def published() -> dict[tuple[str, int, int], list[dict[str, Any]]]:
    """Rows of diagnoses in the table beside the README, by their tasks' keys."""
    from experiments.harness.rows import read_rows

    found: dict[tuple[str, int, int], list[dict[str, Any]]] = {}
    for row in read_rows(Path(__file__).with_name("rows.parquet")):
        if row["part"] == "diagnosis":
            found.setdefault((row["next_trial"], row["situation"], row["seed"]), []).append(row)
    return found


def _key(task: Task) -> tuple[str, int, int]:
    return "informative" if task.informative else "drawn", task.situation, task.seed


def _path(task: Task, store: Path) -> Path:
    way, situation, seed = _key(task)
    return store / f"{way}-s{situation:02d}-{seed}.json"


def _labelled(task: Task, row: dict[str, Any]) -> dict[str, Any]:
    return {"part": "diagnosis", "next_trial": _key(task)[0], **{name: row[name] for name in _COLUMNS}}


def _runs(cases: Sequence[RecoveryCase], store: Path) -> list[dict[str, Any]]:
    """A row for each diagnosis of each run that is done."""
    from experiments.harness.recovery_rows import row
    from experiments.harness.recovery_runs import finished

    found, ways = [], {option: way for way, option in LOOP.items()}
    for case in (c for c in cases if finished(c, store)):
        line = row(case, store)
        about = {"part": "loop", "next_trial": ways[case.next_trial], "situation": case.situation, "seed": case.seed}
        for i in range(1, case.settings.passes + 1):
            own = {"trials": i, "right": line[f"right_{i}"], "diagnosis": line[f"diagnosis_{i}"]}
            found.append({**about, **own, "planted": line["planted"], "distance": line[f"trial_{i}"]})
    return found


def report(diagnoses: Sequence[dict[str, Any]], runs: Sequence[dict[str, Any]], options: Options) -> None:
    """Tables, numbers and figure."""
    from experiments.harness.recovery_rows import write_summary
    from experiments.harness.rows import write_rows
    from experiments.recover.next_trial.summary import draw, summary

    rows = [*diagnoses, *runs]
    write_rows(options.out / "rows.parquet", rows)
    write_summary(options.out / "summary.json", summary(rows), size_of_runs=options.size)
    draw(rows, options.out)


if __name__ == "__main__":
    from experiments.harness.study import exit_code

    sys.exit(exit_code(main))
