"""The smallest study: three tiny runs and their table. It is there to be killed and to be spread over machines."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[4]))


def main(arguments: Sequence[str] | None = None) -> int:
    """The runs and their table; whatever size is asked for, it is tiny."""
    from experiments.harness.options import options_of
    from experiments.harness.recovery_case import RecoveryCase, seeds
    from experiments.harness.recovery_rows import row, write_summary
    from experiments.harness.recovery_runs import run_cases
    from experiments.harness.rows import write_rows
    from experiments.harness.study import Study, words

    tiny = [*(word for word in words(arguments) if word != "--quick"), "--size", "tiny"]
    options = options_of(Study.of(__file__, __doc__), tiny, seeds=1, quick_seeds=1)
    cases = [RecoveryCase(situation, seeds(1)[0], options.size, "set") for situation in (1, 3, 5)]
    run_cases(cases, options)
    write_rows(options.out / "rows.parquet", [row(case, options.store) for case in cases])
    write_summary(options.out / "summary.json", {}, seed=seeds(1)[0], size=options.size)
    return 0


if __name__ == "__main__":
    from experiments.harness.study import exit_code

    sys.exit(exit_code(main))
