"""`estexp experiment out_of_catalogue`: laws that the catalogue lacks, or that were taken out of it.

estexp experiment out_of_catalogue --quick                    five laws of no catalogue, of another seed
estexp experiment out_of_catalogue --workers 2 [--resume]     each effect left out, and the five laws
python experiments/explain/out_of_catalogue/run.py run|score --part own --out DIR [--publish]
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))


def main(arguments: Sequence[str] | None = None) -> int:
    """Do what is asked; gives the exit code."""
    from experiments.explain.out_of_catalogue.study import out_of_catalogue

    return out_of_catalogue(__file__, __doc__).main(arguments)


if __name__ == "__main__":
    from experiments.harness.study import exit_code

    sys.exit(exit_code(main))
