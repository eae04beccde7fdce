"""`estexp experiment oracle_diagnosis`: how far the robot comes with its own diagnosis, against one that is handed the truth.

estexp experiment oracle_diagnosis --quick                    one seed, very small runs
estexp experiment oracle_diagnosis --workers 8                10 seeds, 200 genomes, 40 generations, 1000 steps
python experiments/recover/oracle_diagnosis/run.py --size small --robot foreign
python experiments/recover/oracle_diagnosis/run.py --size small --report      table and figure of the runs finished so far
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

ROBOTS = ("same", "foreign")
SITUATIONS = (1, 2, 3, 4, 5, 6, 7, 8, 10)
"""Those of the paper in which something breaks that it can say."""


def main(arguments: Sequence[str] | None = None) -> int:
    """All runs, then the table and the figure."""
    from experiments.harness.options import parsed, publish
    from experiments.harness.runs import finished, run_all

    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--robot", choices=ROBOTS)
    parser.add_argument("--report", action="store_true")
    own, rest = parser.parse_known_args(sys.argv[1:] if arguments is None else list(arguments))
    options = parsed("oracle_diagnosis", __doc__, seeds=10, quick_seeds=1, arguments=rest)
    pairs = pairs_of(options.size, options.n)
    if not own.report:
        run_all([case for pair in pairs for case in pair if own.robot in (None, case.robot)], options)
    report([pair for pair in pairs if all(finished(case, options.store) for case in pair)], options)
    publish(options, __file__)
    return 0


def pairs_of(size, n: int) -> list:
    """Diagnosed and told runs in pairs; seed by seed, so that a run that is stopped leaves whole seeds."""
    from experiments.harness.recovery_case import Case, seeds

    return [
        (Case(s, seed, size, "set", robot=robot), Case(s, seed, size, "told", robot=robot))
        for robot in ROBOTS
        for seed in seeds(n)
        for s in SITUATIONS
    ]


def report(pairs: Sequence, options) -> None:
    """Table, numbers and figure of the pairs that are finished."""
    from experiments.harness.tables import row, write_rows, write_summary
    from experiments.recover.oracle_diagnosis.summary import draw, summary

    rows = [(row(own, options.store), row(told, options.store)) for own, told in pairs]
    write_rows(options.out / "runs.csv", [r for pair in rows for r in pair])
    seeds = sorted({case.seed for case, _ in pairs})
    write_summary(options.out / "summary.json", summary(rows), seeds=seeds, size=options.size)
    draw(rows, options.out)


if __name__ == "__main__":
    from experiments.harness.options import exit_code

    sys.exit(exit_code(main))
