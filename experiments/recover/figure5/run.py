"""`estexp experiment figure5`: the paper's Figure 5a, how walks of two robots diverge, and what h and w are good for.

estexp experiment figure5 --quick     3 controllers, 200 steps
estexp experiment figure5             100 walkers of the library, 1000 steps
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))


def main(arguments: Sequence[str] | None = None) -> int:
    """Simulate, measure, draw."""
    import numpy as np

    from experiments.harness.options import options_of
    from experiments.harness.recovery_rows import write_summary
    from experiments.harness.rows import write_rows
    from experiments.harness.study import Study
    from experiments.recover.figure5.figure import draw
    from experiments.recover.figure5.measure import HEADERS, correlations, divergences, traces

    study = Study.of(__file__, __doc__)
    options = options_of(study, arguments, seeds=100, quick_seeds=3)
    steps = 200 if options.quick else 1000
    found = traces(options.n, steps, options.out / "traces.cache")
    times, table = divergences(found), correlations(found, [h for h in HEADERS if h <= steps - 1])
    write_rows(options.out / "times.parquet", times)
    write_rows(options.out / "correlations.parquet", table)
    columns = {name: np.array([row[name] for row in times]) for name in ("similar", "unlike")}
    summary = draw(found, columns, table, options.out)
    write_summary(options.out / "summary.json", summary, controllers=options.n, steps=steps, library="walkers.npz")
    study.publish(options.out, options.publish)
    return 0


if __name__ == "__main__":
    from experiments.harness.study import exit_code

    sys.exit(exit_code(main))
