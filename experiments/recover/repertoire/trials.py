"""Maps of gaits of the healthy robot, and the trials of a damaged robot that has one and no diagnosis."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.exploration.explore import validation_ensemble
from estexp_jax.runs import write_json
from estexp_jax.runs.files import replacing
from experiments.harness.recovery_case import RecoveryCase
from experiments.harness.recovery_rows import result
from experiments.harness.recovery_runs import finished
from experiments.harness.world import job, trial_of, world
from experiments.recover.repertoire.repertoire import Repertoire, adapted, evolved

TRIALS = 20
"""On the damaged robot, without diagnosis; the full algorithm has five, that of the old controller among them."""
MAPS = {"repertoire": 1, "tenfold": 10}
"""Walks that a map is made of, as multiples of those that the full algorithm simulates in its explorations."""


def map_path(case: RecoveryCase, way: str, store: Path) -> Path:
    """Of the map that all runs of a seed share."""
    return store / way / f"{case.robot}-{case.seed}.npz"


def trials_path(case: RecoveryCase, way: str, store: Path) -> Path:
    """Of a run's trials."""
    return store / way / f"{case.name}.json"


def budget(settings: Settings) -> int:
    """Walks that the full algorithm simulates in its explorations, those that judge the last generation included."""
    each = settings.population + (settings.generations - 1 + validation_ensemble(settings)) * (settings.population // 2)
    return (settings.passes + 1) * each


def evolve_map(case: RecoveryCase, way: str, store: Path) -> None:
    """Make the map of a seed's healthy robot."""
    path = map_path(case, way, store)
    path.parent.mkdir(parents=True, exist_ok=True)
    *_, found = evolved(world(case.size), case.settings, MAPS[way] * budget(case.settings))
    with replacing(path) as stream:
        np.savez_compressed(stream, weights=found.weights, duty=found.duty, distance=found.distance)


def try_gaits(case: RecoveryCase, way: str, store: Path) -> None:
    """Make a damaged robot's trials."""
    with np.load(map_path(case, way, store)) as archive:
        gaits = Repertoire(archive["weights"], archive["duty"], archive["distance"])
    run, settings = job(case), case.settings

    def trial(weights: np.ndarray) -> float:
        return trial_of(run, weights, settings.steps).distance(settings.axis)

    tried = adapted(gaits, trial, TRIALS)
    write_json(
        trials_path(case, way, store),
        {"gaits": len(gaits.distance), "best": float(np.max(gaits.distance)), "distances": [d for _, d in tried]},
    )


def rows_of(cases: Sequence[RecoveryCase], store: Path, runs: Path) -> list[dict[str, Any]]:
    """A row for each case of which all is finished."""
    found = []
    for case in cases:
        paths = {way: trials_path(case, way, store) for way in MAPS}
        if finished(case, runs) and all(path.is_file() for path in paths.values()):
            own = result(case, runs)
            trials = [own["distance"]["damaged"], *(each["hardware_m"] for each in own["passes"])]
            row = {"robot": case.robot, "situation": case.situation, "seed": case.seed}
            row |= {"before": own["distance"]["before"], **{f"diagnosis_{i}": d for i, d in enumerate(trials)}}
            for way, path in paths.items():
                other = json.loads(path.read_text(encoding="utf-8"))
                row |= {f"gaits_{way}": other["gaits"], f"best_{way}": other["best"]}
                row |= {f"{way}_{i}": d for i, d in enumerate(other["distances"])}
            found.append(row)
    return found
