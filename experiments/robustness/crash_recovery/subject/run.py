"""The smallest experiment: three tiny runs and their table. It is there to be killed and to be spread over machines."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[4]))


def main(arguments: Sequence[str] | None = None) -> int:
    """The runs and their table; whatever size is asked for, it is tiny."""
    from experiments.harness.options import parsed
    from experiments.harness.recovery_case import Case, seeds
    from experiments.harness.runs import run_all
    from experiments.harness.tables import row, write_rows, write_summary

    given = list(sys.argv[1:] if arguments is None else arguments)
    tiny = [*(word for word in given if word != "--quick"), "--size", "tiny"]
    options = parsed("subject", __doc__, seeds=1, quick_seeds=1, arguments=tiny)
    cases = [Case(situation, seeds(1)[0], options.size, "set") for situation in (1, 3, 5)]
    run_all(cases, options)
    write_rows(options.out / "runs.csv", [row(case, options.store) for case in cases])
    write_summary(options.out / "summary.json", {}, seed=seeds(1)[0], size=options.size)
    return 0


if __name__ == "__main__":
    from experiments.harness.options import exit_code

    sys.exit(exit_code(main))
