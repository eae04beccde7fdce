"""`estexp experiment published`: ten real machines explained, beside the values that others published or weighed.

estexp experiment published --quick               two machines of one joint
estexp experiment published --workers 2           all
python experiments/explain/published/run.py --only kr300 tx40
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))


def main(arguments: Sequence[str] | None = None) -> int:
    """Do what is asked; gives the exit code."""
    from experiments.explain.published.study import published

    return published(__file__, __doc__).main(arguments)


if __name__ == "__main__":
    from experiments.harness.study import exit_code

    sys.exit(exit_code(main))
