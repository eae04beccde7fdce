"""A sealed set of nothing but laws that no catalogue holds: how often one is given a wrong name.

python experiments/concealed/odd_laws.py run --workers 2 --publish   the cases; --most N of them, --resume goes on
python experiments/concealed/odd_laws.py score                       once all are there: opened

A sealed set of all groups has some 35 of them that show, too few to tell 5 % from 15 %. These are drawn, explained and
scored as those are (see parts.py), without rivals.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from experiments.common.case_sets import CaseSet  # noqa: E402
from experiments.concealed.generator.case import Plan  # noqa: E402
from experiments.concealed.generator.plans import plans  # noqa: E402
from experiments.concealed.parts import OPENINGS, QUICK, beside, command, opened, sealed_seed  # noqa: E402
from experiments.concealed.scoring.board import UNNAMED  # noqa: E402
from experiments.concealed.sets import SEALED  # noqa: E402

DRAWN_OF = 720
"""Cases of the set of all groups that these are drawn from: 86 of them, some 60 visible."""
_PUBLISHED = Path(__file__).with_name("odd_laws.json")


def main(arguments: Sequence[str] | None = None) -> int:
    """Do what is asked; gives the exit code."""
    asked = sys.argv[1:] if arguments is None else arguments
    return odd_laws(QUICK[0] if "--quick" in asked else sealed_seed(_PUBLISHED)).main(__doc__, arguments)


def odd_laws(seed: int) -> CaseSet:
    """The set of a seed."""
    return CaseSet(
        name="concealed/odd_laws",
        planned=planned,
        parts=("all",),
        seed=seed,
        quick=QUICK,
        published=_PUBLISHED,
        command=command,
        write_scores=partial(opened, OPENINGS if seed != QUICK[0] else None),
        more=partial(beside, ()),
    )


def planned(seed: int, _: str) -> list[Plan]:
    """The plans of a set."""
    return [plan for plan in plans(seed, DRAWN_OF, SEALED) if plan.group in UNNAMED]


if __name__ == "__main__":
    from experiments.common.options import exit_code

    sys.exit(exit_code(main))
