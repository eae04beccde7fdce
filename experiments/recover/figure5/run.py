"""`estexp experiment figure5`: Figure 5a, and what the header h and the window w of the metric are good for.

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

    from experiments.harness.options import parsed, publish
    from experiments.harness.tables import write_rows, write_summary
    from experiments.recover.figure5.figure import draw
    from experiments.recover.figure5.measure import HEADERS, correlations, divergences, traces

    options = parsed("figure5", __doc__, seeds=100, quick_seeds=3, arguments=arguments)
    file = options.out / "traces.cache"
    steps = 200 if options.size == "quick" else 1000
    found = traces(options.n, steps, file)
    times, table = divergences(found), correlations(found, [h for h in HEADERS if h <= steps - 1])
    write_rows(options.out / "times.csv", times)
    write_rows(options.out / "correlations.csv", table)
    columns = {name: np.array([row[name] for row in times]) for name in ("similar", "unlike")}
    summary = draw(found, columns, table, options.out)
    write_summary(options.out / "summary.json", summary, controllers=options.n, steps=steps, library="walkers.npz")
    publish(options, __file__)
    return 0


if __name__ == "__main__":
    from experiments.harness.options import exit_code

    sys.exit(exit_code(main))
