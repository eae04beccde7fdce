"""`estexp experiment figure6`: the paper's Figure 6, one run of situation 5 in full, under three searches.

estexp experiment figure6 --quick
estexp experiment figure6
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))


def main(arguments: Sequence[str] | None = None) -> int:
    """The runs of the first seed, their figures and numbers."""
    from estexp_jax.report.recover.figure import path_figure, progress_figure
    from experiments.harness.figures import write_figure
    from experiments.harness.options import options_of
    from experiments.harness.recovery_case import RecoveryCase, seeds
    from experiments.harness.recovery_rows import row, write_summary
    from experiments.harness.recovery_runs import run_cases, state_of
    from experiments.harness.rows import write_rows
    from experiments.harness.study import Study
    from experiments.recover.figure7.run import ARMS

    study = Study.of(__file__, __doc__)
    options = options_of(study, arguments, seeds=1, quick_seeds=1)
    cases = [RecoveryCase(5, seeds(1)[0], options.size, method, metric) for method, metric in ARMS]
    run_cases(cases, options)
    for case in cases:
        state, name = state_of(case, options.store), f"{case.method}-{case.metric}"
        write_figure(options.out / f"{name}.png", progress_figure(state, case.settings.axis), dpi=100)
        write_figure(options.out / f"{name}-paths.png", path_figure(state, case.settings.axis), dpi=100)
    write_rows(options.out / "rows.parquet", [row(case, options.store) for case in cases])
    write_summary(options.out / "summary.json", {}, seed=seeds(1)[0], size=options.size)
    study.publish(options.out, options.publish)
    return 0


if __name__ == "__main__":
    from experiments.harness.study import exit_code

    sys.exit(exit_code(main))
