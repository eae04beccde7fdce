"""`estexp experiment robots`: recovery on robots that the program was not made for, a hexapod and the Unitree Go1.

estexp experiment robots --quick
python experiments/recover/robots/run.py --size small      # as `estexp recover --quick`; what the README shows
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))


def main(arguments: Sequence[str] | None = None) -> int:
    """Every damage on every robot with every seed; a table, a figure, and what it looks like."""
    from experiments.harness.figures import write_figure
    from experiments.harness.options import options_of
    from experiments.harness.recovery_case import seeds
    from experiments.harness.recovery_rows import write_summary
    from experiments.harness.rows import write_rows
    from experiments.harness.study import Study
    from experiments.recover.robots.cases import DAMAGES, RobotCase, outcome
    from experiments.recover.robots.figure import distances_figure
    from experiments.recover.robots.pictures import show

    study = Study.of(__file__, __doc__)
    options = options_of(study, arguments, seeds=3, quick_seeds=1)
    cases = [
        RobotCase(model, damage, seed, options.size)
        for seed in seeds(options.n)
        for model, damages in DAMAGES.items()
        for damage in damages
    ]
    rows = []
    for number, case in enumerate(cases, start=1):
        rows.append(outcome(case, options.store))
        print(f"{number} of {len(cases)}: {case.name}: {rows[-1]['in_words']}", flush=True)
    write_rows(options.out / "rows.parquet", rows)
    summary = {"right": sum(row["right"] for row in rows), "of": len(rows)}
    write_summary(options.out / "summary.json", summary, size=options.size, seeds=list(seeds(options.n)))
    write_figure(options.out / "distances.png", distances_figure(rows))
    for model in DAMAGES:
        show(next(case for case in cases if case.model == model), options.store, options.out)
    study.publish(options.out, options.publish)
    return 0


if __name__ == "__main__":
    from experiments.harness.study import exit_code

    sys.exit(exit_code(main))
