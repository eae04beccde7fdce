"""A sealed set of nothing but laws that no catalogue holds: how often one is given a wrong name.

python experiments/benchmark/outside_catalogue.py run --workers 2 --publish   the cases; --most N of them, --resume goes on
python experiments/benchmark/outside_catalogue.py score                       once all are there: opened

A sealed set of all groups has some 35 of them that show, too few to tell 5 % from 15 %. These are drawn, explained and
scored as those are (see sealed.py), without rivals.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from experiments.benchmark.generator.case import Plan  # noqa: E402
from experiments.benchmark.generator.plans import plans  # noqa: E402
from experiments.benchmark.scoring.board import UNNAMED  # noqa: E402
from experiments.benchmark.sealed import beside, sealed_set, seed_asked  # noqa: E402
from experiments.benchmark.sets import SEALED  # noqa: E402
from experiments.harness.explain_study import CaseSet  # noqa: E402

DRAWN_OF = 720
"""Cases of the set of all groups that these are drawn from: 86 of them, 56 visible in the one that is opened."""
_PUBLISHED = Path(__file__).with_name("odd_laws.json")


def main(arguments: Sequence[str] | None = None) -> int:
    """Do what is asked; gives the exit code."""
    return odd_laws(seed_asked(_PUBLISHED, arguments)).main(__doc__, arguments)


def odd_laws(seed: int) -> CaseSet:
    """The set of a seed: a sealed one, but for what it holds."""
    name = "concealed/odd_laws"
    return replace(sealed_set(seed), name=name, planned=planned, published=_PUBLISHED, more=partial(beside, ()))


def planned(seed: int, _: str) -> list[Plan]:
    """The plans of a set."""
    return [plan for plan in plans(seed, DRAWN_OF, SEALED) if plan.group in UNNAMED]


if __name__ == "__main__":
    from experiments.harness.options import exit_code

    sys.exit(exit_code(main))
