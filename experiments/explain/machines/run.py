"""`estexp experiment machines`: explain recordings of real machines, and logs from which something known is withheld.

estexp experiment machines --quick                pieces of the recordings, one split a device
estexp experiment machines                        everything; long
python experiments/explain/machines/run.py --only xl330-kp800 xl330-late-command
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))


def main(arguments: Sequence[str] | None = None) -> int:
    """Do what is asked; gives the exit code."""
    from experiments.explain.machines.study import machines

    return machines(__file__, __doc__).main(arguments)


if __name__ == "__main__":
    from experiments.harness.study import exit_code

    sys.exit(exit_code(main))
