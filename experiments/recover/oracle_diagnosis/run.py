"""`estexp experiment oracle_diagnosis`: how far the robot comes with its own diagnosis and with the true one.

estexp experiment oracle_diagnosis --quick                    one seed, very small runs
estexp experiment oracle_diagnosis --workers 8                10 seeds, 200 genomes, 40 generations, 1000 steps
python experiments/recover/oracle_diagnosis/run.py --size small --robot foreign
python experiments/recover/oracle_diagnosis/run.py --size small --report      table and figure of what is finished
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from experiments.harness.options import Options
    from experiments.harness.recovery_case import RecoveryCase, Size

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

ROBOTS = ("same", "foreign")
SITUATIONS = (1, 2, 3, 4, 5, 6, 7, 8, 10)
"""Those of the paper in which something breaks that it can say."""


def main(arguments: Sequence[str] | None = None) -> int:
    """All runs, then the table and the figure."""
    from experiments.harness.options import options_of, options_parser
    from experiments.harness.recovery_runs import finished, run_cases
    from experiments.harness.study import Study

    study = Study.of(__file__, __doc__)
    parser = options_parser(study, seeds=10)
    parser.add_argument("--robot", choices=ROBOTS, help="default: both")
    options = options_of(study, arguments, seeds=10, quick_seeds=1, parser=parser)
    pairs, robot = pairs_of(options.size, options.n), options.given.robot
    if not options.report:
        run_cases([case for pair in pairs for case in pair if robot in (None, case.robot)], options)
    report([pair for pair in pairs if all(finished(case, options.store) for case in pair)], options)
    study.publish(options.out, options.publish)
    return 0


def pairs_of(size: Size, n: int) -> list[tuple[RecoveryCase, RecoveryCase]]:
    """A run that diagnoses, and one that knows; seed by seed, so that a run that is stopped leaves whole seeds."""
    from experiments.harness.recovery_case import RecoveryCase, seeds

    return [
        (RecoveryCase(s, seed, size, "set", robot=robot), RecoveryCase(s, seed, size, "oracle", robot=robot))
        for robot in ROBOTS
        for seed in seeds(n)
        for s in SITUATIONS
    ]


def report(pairs: Sequence[tuple[RecoveryCase, RecoveryCase]], options: Options) -> None:
    """Table, numbers and figure of the pairs that are finished."""
    from experiments.harness.recovery_rows import row, write_summary
    from experiments.harness.rows import write_rows
    from experiments.recover.oracle_diagnosis.summary import draw, summary

    rows = [(row(own, options.store), row(oracle, options.store)) for own, oracle in pairs]
    write_rows(options.out / "rows.parquet", [r for pair in rows for r in pair])
    seeds = sorted({case.seed for case, _ in pairs})
    write_summary(options.out / "summary.json", summary(rows), seeds=seeds, size=options.size)
    draw(rows, options.out)


if __name__ == "__main__":
    from experiments.harness.study import exit_code

    sys.exit(exit_code(main))
