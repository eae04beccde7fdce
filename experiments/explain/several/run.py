"""`estexp experiment several`: three to eight effects at once on arms, with errors and a flaw that has no name.

estexp experiment several --quick                    six cases with effects and six without, of another seed
estexp experiment several --workers 2 [--resume]     the whole set, 160 cases
python experiments/explain/several/run.py run|score --part nothing --out DIR [--publish]
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))


def main(arguments: Sequence[str] | None = None) -> int:
    """Do what is asked; gives the exit code."""
    from experiments.explain.several.study import several

    return several(__file__, __doc__).main(arguments)


if __name__ == "__main__":
    from experiments.harness.study import exit_code

    sys.exit(exit_code(main))
