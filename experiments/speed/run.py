"""`estexp experiment speed`: the bench on the quadruped, with its twelve contacts and with its feet alone.

Numbers belong together, so all are measured anew, one at a time, whatever --resume and --workers say.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure; gives the exit code."""
    from estexp_jax.cli.main import main as estexp
    from experiments.harness.study import Study, words

    study = Study.of(__file__, __doc__)
    given = study.parser().parse_args(words(arguments))
    out = study.results(given.out)
    options = ["--force", *(["--quick"] if given.quick else [])]
    sweep = [] if given.quick else ["--sweep"]
    code = estexp(["bench", "--out", str(out / "quadruped"), *options, *sweep])
    return code or estexp(["bench", "--out", str(out / "feet"), "--feet", *options])


if __name__ == "__main__":
    from experiments.harness.study import exit_code

    sys.exit(exit_code(main))
