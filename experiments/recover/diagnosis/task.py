"""One diagnosis: a damaged robot is driven by walkers of the library, and an estimation names what is broken."""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Literal

import numpy as np

from estexp_jax.physics.effects.changes import Change
from estexp_jax.recovery.config import Catalogue, Settings
from estexp_jax.recovery.control.trial import Trial
from estexp_jax.recovery.cycle import Job, job_of
from estexp_jax.recovery.estimation.choice import estimation_of, hypothesis_cost_of
from estexp_jax.recovery.estimation.damage_sites import changes_of
from estexp_jax.recovery.estimation.method import DamageDiagnosis
from estexp_jax.recovery.exploration.disagreement import most_informative, remaining_probability
from experiments.harness.diagnosis_score import amount_error, same_set, text
from experiments.harness.world import quadruped, short_world, trial_of

LIBRARY = Path(__file__).resolve().parents[2] / "walkers" / "walkers.npz"
STEPS = 60
_CANDIDATES = 48
"""Walkers that the next trial is chosen from."""


@dataclass(frozen=True)
class Task:
    """What is diagnosed, from how many trials, and how.

    Attributes:
        situation, seed, robot: of the case.
        catalogue, paper: what the search chooses from, and whether it is the paper's.
        trials: numbers of trials after which there is a diagnosis, each begun with the one before.
        informative: whether the next walker is the most informative one instead of one that is drawn.
    """

    situation: int
    seed: int
    robot: Literal["same", "foreign"]
    catalogue: Catalogue = "full"
    paper: bool = False
    trials: tuple[int, ...] = (1, 2, 4)
    informative: bool = False

    @property
    def kind(self) -> str:
        """The search, and what it chooses from."""
        return "paper" if self.paper else f"set-{self.catalogue}"

    @property
    def settings(self) -> Settings:
        """Of the run that it stands for."""
        return Settings(
            situation=self.situation,
            seed=self.seed,
            robot=self.robot,
            catalogue=self.catalogue,
            paper=self.paper,
            steps=STEPS,
        )


@cache
def library() -> np.ndarray:
    """Weights of the walkers, (walkers, n_weights)."""
    with np.load(LIBRARY) as archive:
        return archive["percent"] / 100.0


def diagnose(task: Task) -> list[dict[str, Any]]:
    """A row for each number of trials; each estimation begins with the diagnosis before, as in the whole loop."""
    job = job_of(quadruped(), task.settings, world=short_world())
    drawn = list(np.random.default_rng([task.seed, task.situation]).permutation(len(library())))
    controllers, trials, seeds, rows = [], [], [], []
    before = trial_of(job, library()[drawn[0]], STEPS, healthy=True)
    for number in task.trials:
        while len(trials) < number:
            controllers.append(library()[drawn.pop(0)])
            trials.append(trial_of(job, controllers[-1], STEPS))
        begin = time.monotonic()
        found, seed = _estimated(job, number, controllers, trials, before, seeds)
        seeds.append(seed)
        rows.append(_row(task, number, job.planted, found, time.monotonic() - begin))
        if task.informative and found.alternatives:
            drawn.insert(0, drawn.pop(_most_informative(job, found, library()[drawn[:_CANDIDATES]])))
    return rows


def _most_informative(job: Job, found: DamageDiagnosis, controllers: np.ndarray) -> int:
    """Index of the controller on which a diagnosis and its rivals disagree most."""
    weighted = [(found.items, found.probability or 0.0), *found.alternatives]
    explanations = [(changes_of(job.simulator, items), p) for items, p in weighted]
    return most_informative(remaining_probability(job.simulator, job.settings, controllers, explanations))


def _estimated(
    job: Job, number: int, controllers: list[np.ndarray], trials: list[Trial], before: Trial, seeds: list[Any]
) -> tuple[DamageDiagnosis, Any]:
    method = estimation_of(job.simulator, job.settings, number)
    residuals = hypothesis_cost_of(job.simulator, job.settings, controllers, trials, [(controllers[0], before)])
    state = method.begin(seeds)
    while not method.done(state):
        state = method.advance(state, residuals)
    return method.diagnosis(state), method.seed(state)


def _row(
    task: Task, number: int, planted: tuple[Change, ...], found: DamageDiagnosis, seconds: float
) -> dict[str, Any]:
    world = short_world()
    diagnosis = changes_of(world, found.items)
    rivals = [changes_of(world, items) for items, _ in found.alternatives]
    return {
        "robot": task.robot,
        "method": "paper" if task.paper else "set",
        "catalogue": task.catalogue,
        "situation": task.situation,
        "seed": task.seed,
        "trials": number,
        "right": same_set(planted, diagnosis),
        "error": amount_error(quadruped(), planted, diagnosis),
        "among_rivals": any(same_set(planted, rival) for rival in rivals),
        "probability": found.probability,
        "alarm": found.alarm,
        "residual": found.residual,
        "planted": text(planted),
        "diagnosis": text(diagnosis),
        "rivals": " | ".join(f"{p:.2f} {text(c)}" for c, (_, p) in zip(rivals, found.alternatives, strict=True)),
        "seconds": seconds,
    }
