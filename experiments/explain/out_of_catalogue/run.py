"""`estexp experiment out_of_catalogue`: laws that the catalogue lacks, or that were taken out of it.

estexp experiment out_of_catalogue --quick                    five laws of no catalogue, of another seed
estexp experiment out_of_catalogue --workers 2 [--resume]     each joint's and motor's effect left out, and the five laws
python experiments/explain/out_of_catalogue/run.py run|score --part own --out DIR [--publish]
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT))


def main(arguments: Sequence[str] | None = None) -> int:
    """Do what is asked; gives the exit code."""
    from experiments.explain.out_of_catalogue.study import UNNAMED

    return UNNAMED.main(__doc__, arguments)


if __name__ == "__main__":
    from experiments.harness.options import exit_code

    sys.exit(exit_code(main))
