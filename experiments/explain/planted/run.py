"""`estexp experiment planted`: every effect planted and recovered.

estexp experiment planted --quick                    two effects at once, 20 cases
estexp experiment planted --workers 2 [--resume]     the whole set, 490 cases
python experiments/explain/planted/run.py run|score --part single --out DIR [--publish]
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))


def main(arguments: Sequence[str] | None = None) -> int:
    """Do what is asked; gives the exit code."""
    from experiments.explain.planted.study import planted

    return planted(__file__, __doc__).main(arguments)


if __name__ == "__main__":
    from experiments.harness.study import exit_code

    sys.exit(exit_code(main))
