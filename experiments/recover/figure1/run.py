"""`estexp experiment figure1`: Figure 1, evolving on the damaged robot itself, against the full algorithm.

estexp experiment figure1 --quick
estexp experiment figure1 --workers 8
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))


def main(arguments: Sequence[str] | None = None) -> int:
    """Both ways for every seed, table and figure."""
    from experiments.harness.options import parsed, publish
    from experiments.harness.recovery_case import Case, seeds
    from experiments.harness.runs import each, run_all
    from experiments.harness.tables import write_rows, write_summary
    from experiments.recover.figure1.direct import compared, courses, direct
    from experiments.recover.figure1.figure import draw

    options = parsed("figure1", __doc__, seeds=10, quick_seeds=2, arguments=arguments)
    legs = ("f", "l", "b", "r")
    damaged = [(seed, (f"part_lost@lower_{legs[seed % 4]}",)) for seed in seeds(options.n)]
    cases = [
        Case(None, seed, options.size, method, damage=damage) for seed, damage in damaged for method in ("set", "paper")
    ]
    run_all(cases, options)
    runs = each("on the robot", [(direct, case, options.store) for case in cases[::2]], options)
    rows = compared(cases, runs, options.store)
    write_rows(options.out / "trials.csv", rows)
    found = draw(runs, courses(cases, options.store), rows, options.out)
    write_summary(options.out / "summary.json", found, seeds=options.n, size=options.size)
    publish(options, __file__)
    return 0


if __name__ == "__main__":
    from experiments.harness.options import exit_code

    sys.exit(exit_code(main))
