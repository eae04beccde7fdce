"""A sealed set of nothing but laws that no catalogue holds: how often one is given a wrong name.

python experiments/benchmark/run.py outside_catalogue run --workers 2 --publish   --most N of them, --resume goes on
python experiments/benchmark/run.py outside_catalogue score                       once all are there: opened

A sealed set of all groups has some 35 of them that show, too few to distinguish 5 % from 15 %. These are drawn,
explained and scored as those are (see sealed.py), without baselines.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

from experiments.benchmark.generator.case import Plan
from experiments.benchmark.generator.plans import plans
from experiments.benchmark.scoring.board import OUTSIDE_CATALOGUE
from experiments.benchmark.sealed import beside, sealed_set, seed_asked
from experiments.benchmark.sets import SEALED
from experiments.harness.explain_study import numbered
from experiments.harness.study import Study

DRAWN_OF = 720
"""Cases of the set of all groups that these are drawn from: 86 of them, 56 visible in the first that was opened."""


def main(study: Study, arguments: Sequence[str]) -> int:
    """Do what is asked; gives the exit code."""
    published = study.folder / "outside_catalogue.parquet"
    whole = sealed_set(study, seed_asked(published, arguments), published)
    return replace(whole, planned=partial(numbered, planned), beside=partial(beside, ())).main(arguments)


def planned(seed: int, _: str) -> list[Plan]:
    """The plans of a set."""
    return [plan for plan in plans(seed, DRAWN_OF, SEALED) if plan.group in OUTSIDE_CATALOGUE]
