"""`estexp experiment benchmark`: explain recordings with concealed effects, score against sealed answers.

estexp experiment benchmark --quick                  a development set of 40 cases, explained and scored
estexp experiment benchmark --workers 2 [--resume]   the sealed set of this commit: seal, run, baselines, open

python experiments/benchmark/run.py COMMAND ...      --help after a command says more
  draw, seal, run, baselines, score, open            steps of a set that stands whole on disk
  sealed run|score                                   the sealed set some cases at a time, on any machine
  outside_catalogue run|score                        a sealed set of nothing but laws that no catalogue holds
  repeat CASES run|score                             an opened set by the program as it is now
  absorbed CASES                                     mujoco.sysid on all absorbed cases of an opened set
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))


def main(arguments: Sequence[str] | None = None) -> int:
    """Do what is asked; gives the exit code."""
    from experiments.benchmark import absorbed, on_disk, outside_catalogue, repeat, sealed
    from experiments.harness.study import Study, words

    commands = {"sealed": sealed, "outside_catalogue": outside_catalogue, "repeat": repeat, "absorbed": absorbed}
    given = words(arguments)
    if given and given[0] in commands:
        command = commands[given[0]]
        return command.main(Study(Path(__file__).resolve(), command.__doc__, given[0]), given[1:])
    return on_disk.main(Study.of(__file__, __doc__), given)


if __name__ == "__main__":
    from experiments.harness.study import exit_code

    sys.exit(exit_code(main))
