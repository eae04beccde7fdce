"""Dominants: new genomes that are better than all of the generation before."""

from __future__ import annotations

import json
from pathlib import Path
from typing import NamedTuple

import numpy as np

from estexp_jax.recovery.estimation.choice import hypothesis_cost_of
from estexp_jax.recovery.estimation.genome import LENGTH, GenomeDecoder, hypothesis_key
from estexp_jax.runs import write_json
from estexp_jax.search.genetic import RESOLUTION
from experiments.harness.recovery_case import RecoveryCase
from experiments.harness.recovery_runs import state_of
from experiments.harness.world import job, quadruped

_TAG = 29


class Count(NamedTuple):
    """One estimation."""

    situation: int
    metric: str
    search: str  #: evolved or random
    seed: int
    estimation: int  #: from 1
    generations: int  #: with at least one dominant
    dominants: int  #: in all
    residual: float  #: at the end


def counted(case: RecoveryCase, store: Path) -> list[Count]:
    """The estimations of a finished run."""
    state, found = state_of(case, store), []
    for number in sorted({row.number for row in state.history if row.phase == "estimation"}):
        rows = [row for row in state.history if row.phase == "estimation" and row.number == number]
        new = [row.dominant for row in rows]
        some = sum(n > 0 for n in new)
        found.append(Count(_known(case), case.metric, "evolved", case.seed, number, some, sum(new), rows[-1].best))
    return found


def random_search(case: RecoveryCase, store: Path) -> Count:
    """As many random genomes on the run's first trial, in generations of the same sizes; kept beside the run."""
    path = store / case.name / "random.json"
    if path.is_file():
        return Count(**json.loads(path.read_text(encoding="utf-8")))
    state, settings, codec = state_of(case, store), case.settings, GenomeDecoder(quadruped())
    residuals = hypothesis_cost_of(job(case).simulator, settings, state.controllers[:1], state.trials[:1])
    random = np.random.default_rng([case.seed, _TAG, _known(case)])
    new = settings.population - settings.population // 2
    sizes = [settings.population, *[new] * (settings.generations - 1)]
    genomes = random.integers(-RESOLUTION, RESOLUTION + 1, size=(sum(sizes), LENGTH)) / RESOLUTION
    items = [codec.items(genome) for genome in genomes]
    different = {hypothesis_key(i): i for i in items}
    values = dict(zip(different, residuals(list(different.values())), strict=True))
    parts = np.split(np.array([values[hypothesis_key(i)] for i in items]), np.cumsum(sizes)[:-1])
    least = np.minimum.accumulate([part.min() for part in parts])
    better = [int(np.sum(part < before)) for part, before in zip(parts[1:], least, strict=False)]
    some = sum(n > 0 for n in better)
    count = Count(_known(case), case.metric, "random", case.seed, 1, some, sum(better), float(least[-1]))
    write_json(path, count._asdict())
    return count


def _known(case: RecoveryCase) -> int:
    if case.situation is None:
        raise ValueError("dominants are counted by situation")
    return case.situation
