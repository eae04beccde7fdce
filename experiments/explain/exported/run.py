"""`estexp experiment exported`: every effect planted on two robots, found, and written into MJCF and explained.py.

estexp experiment exported --quick               two cases
estexp experiment exported [--resume]            all 76: minutes each
python experiments/explain/exported/run.py --given    what was planted is exported, nothing is explained: seconds each
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))


def main(arguments: Sequence[str] | None = None) -> int:
    """Do what is asked; gives the exit code."""
    from experiments.explain.exported.study import main_of
    from experiments.harness.study import Study

    return main_of(Study.of(__file__, __doc__), arguments)


if __name__ == "__main__":
    from experiments.harness.study import exit_code

    sys.exit(exit_code(main))
