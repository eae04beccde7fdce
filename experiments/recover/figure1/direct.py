"""Evolution on the damaged robot: every evaluation is a hardware trial."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from estexp_jax.recovery.exploration.explore import exploration_score
from estexp_jax.runs import write_json
from estexp_jax.search.driver import evolve
from estexp_jax.search.genetic import Genetic
from experiments.harness.recovery_case import RecoveryCase
from experiments.harness.recovery_rows import result
from experiments.harness.recovery_runs import state_of
from experiments.harness.world import job

RECOVERED = 0.8
"""Share of the distance before the damage that counts as recovered."""
LONGER = 4
"""Generations on the robot, in those of a phase."""
_TAG = 31


def direct(case: RecoveryCase, store: Path) -> dict[str, Any]:
    """Best distance so far after each hardware trial, starting from the walker of before the damage; kept."""
    path = store / case.name / "direct.json"
    if path.is_file():
        return json.loads(path.read_text(encoding="utf-8"))
    work, state, settings = job(case), state_of(case, store), case.settings
    score, walked = exploration_score(work.simulator, settings, work.planted), []

    def trial(genomes: np.ndarray) -> np.ndarray:
        values = score(genomes)
        walked.extend(-values)
        return values

    length = work.simulator.n_weights
    genetic = Genetic(length, settings.population, settings.seed, (_TAG,), settings.mutation)
    for _ in evolve(genetic, trial, LONGER * settings.generations, seeds=state.controllers[:1]):
        pass
    assert state.before is not None
    before = state.before.distance(settings.axis)
    best = np.maximum.accumulate(np.where(np.isfinite(walked), walked, -np.inf))
    found = {"seed": case.seed, "before": before, "best": best.tolist(), "needed": _needed(best, before)}
    write_json(path, found)
    return found


def compared(cases: Sequence[RecoveryCase], runs: Sequence[dict[str, Any]], store: Path) -> list[dict[str, Any]]:
    """A row for each seed: trials until recovery; None where it did not come to it."""
    rows = []
    walked = courses(cases, store)
    for i, (own, run) in enumerate(zip(cases[::2], runs, strict=True)):
        line = {"seed": run["seed"], "damage": own.damage[0], "before": run["before"], "on_the_robot": run["needed"]}
        for name, all_of_it in walked.items():
            line[name] = _needed(np.maximum.accumulate(all_of_it[i]), run["before"])
            line[f"{name}_share"] = all_of_it[i][-1] / run["before"]
        line |= {"on_the_robot_share": run["best"][-1] / run["before"], "trials_on_the_robot": len(run["best"])}
        rows.append(line)
    return rows


def courses(cases: Sequence[RecoveryCase], store: Path) -> dict[str, list[list[float]]]:
    """Distances of the full algorithm's trials, m, seed by seed; the one in which the robot was damaged counts."""
    found = [result(case, store) for case in cases]
    walked = [[each["distance"]["damaged"], *(p["hardware_m"] for p in each["passes"])] for each in found]
    return {"set_search": walked[::2], "paper": walked[1::2]}


def _needed(best: np.ndarray, before: float) -> int | None:
    """Trials until 80 % is recovered."""
    reached = np.flatnonzero(np.asarray(best) >= RECOVERED * before)
    return int(reached[0]) + 1 if len(reached) else None
