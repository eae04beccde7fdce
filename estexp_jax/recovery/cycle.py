"""The estimation-exploration algorithm: walk, get damaged, diagnose from the sensors, walk again.

Phases: exploration; damage, whose trial is the first recording; then `passes` times estimation, exploration and
hardware trial. A generator yields the state after every generation and every trial. A run that is resumed from any of
these states gives the same results bit for bit.

Source: Bongard and Lipson 2004, section 2.1 and Figure 2a.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from estexp_jax.errors import InputError
from estexp_jax.physics.effects.changes import Change, parse_change
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.config import DEFAULT_MODEL_ERROR, Settings
from estexp_jax.recovery.control.trial import Trial
from estexp_jax.recovery.estimation.choice import estimation_of, hypothesis_cost_of
from estexp_jax.recovery.estimation.damage_sites import changes_of
from estexp_jax.recovery.exploration.disagreement import most_informative, remaining_probability
from estexp_jax.recovery.exploration.explore import exploration_algorithm, exploration_score, rank_controllers
from estexp_jax.recovery.reality_gap_target import RealityGapTarget
from estexp_jax.recovery.simulator import DamageSimulator, damage_simulator
from estexp_jax.recovery.situations import situation
from estexp_jax.recovery.state import Row, RunState
from estexp_jax.recovery.target import RemoteTarget, SameTarget, Target, trial_of_result
from estexp_jax.search.driver import evolve
from estexp_jax.search.genetic import Population

_NEARLY_AS_FAR, _MAX_CANDIDATES = 0.8, 48
"""A controller may be tried next if it goes at least this share of the best distance; so many are compared."""


@final
@dataclass(frozen=True, eq=False)
class Job:
    """The inputs of a run.

    Attributes:
        settings: of the run.
        simulator: of the undamaged robot.
        planted: true damage of the robot in the world, for the record; empty if unknown.
        target: the damaged robot.
        healthy: the robot before the damage; None if not available: the simulator stands in for it.
    """

    settings: Settings
    simulator: DamageSimulator
    planted: tuple[Change, ...]
    target: Target | RemoteTarget
    healthy: Target | RemoteTarget | None

    @property
    def stands_in(self) -> bool:
        """Whether the simulator stands in for the robot before the damage."""
        return self.healthy is None


def planted_changes(robot: Robot, settings: Settings) -> tuple[Change, ...]:
    """The damage that a run's settings ask for.

    Raises:
        InputError: the situation or a damage has no place on this robot.
    """
    if settings.damage:
        return tuple(parse_change(text, robot) for text in settings.damage)
    return situation(settings.situation, robot, settings.seed) if settings.situation is not None else ()


def job_of(
    robot: Robot,
    settings: Settings,
    target: Target | RemoteTarget | None = None,
    *,
    healthy: Target | RemoteTarget | None = None,
    world: DamageSimulator | None = None,
) -> Job:
    """Prepare a run.

    Args:
        robot: the nominal robot.
        settings: of the run.
        target: the robot in the world, already damaged; None: a simulated one with the damage of `settings`.
        healthy: with `target`, the same robot before the damage, if available.
        world: a simulator of the robot to reuse; its catalogue must hold the damage.

    Raises:
        InputError: the damage cannot be planted, or the robot cannot be controlled or cannot travel.
    """
    if target is not None and settings.model_error is None:
        settings = replace(settings, model_error=DEFAULT_MODEL_ERROR)
    planted = planted_changes(robot, settings) if target is None else ()
    world = damage_simulator(robot, settings, planted) if world is None else world
    if target is not None:
        return Job(settings, world, (), target, healthy)
    if settings.robot == "foreign":
        robots = [RealityGapTarget(robot, changes, settings.seed, settings.settle_steps) for changes in (planted, ())]
        return Job(settings, world, planted, *robots)
    return Job(settings, world, planted, SameTarget(world, planted), SameTarget(world, ()))


def run_cycle(job: Job, state: RunState | None = None) -> Iterator[RunState]:
    """Yield the state after each generation and each trial, to the end of the run.

    Args:
        job: inputs of the run.
        state: an earlier state of the same job to resume from.

    Raises:
        InputError: every simulation of a phase diverged.
    """
    state = RunState() if state is None else state
    phases = {"exploration": _explore, "damage": _damage, "estimation": _estimate, "trial": _trial}
    while state.phase != "done":
        for reached in phases[state.phase](job, state):
            state = reached
            yield state


def _explore(job: Job, state: RunState) -> Iterator[RunState]:
    settings, number = job.settings, state.number
    changes = state.diagnoses[-1] if state.diagnoses else ()
    score = exploration_score(job.simulator, settings, changes)
    earlier = None if state.search is None else Population.from_tree(dict(state.search))
    algorithm = exploration_algorithm(job.simulator, settings, number)
    for population in evolve(algorithm, score, settings.generations, seeds=state.controllers, state=earlier):
        row = _row(number, "exploration", population.generation, -population.scores, population.dominants)
        state = replace(state, search=population.to_tree(), history=(*state.history, row))
        if population.generation < settings.generations:
            yield state
    population = Population.from_tree(dict(state.search or {}))
    last = number >= settings.passes
    candidates = rank_controllers(job.simulator, settings, changes, population, state.controllers, last=last)
    weights, value = _next_controller(job, state, *candidates)
    yield replace(
        state,
        phase="trial" if number else "damage",
        search=None,
        controllers=(*state.controllers, weights),
        simulated=(*state.simulated, -value),
    )


def _next_controller(job: Job, state: RunState, genomes: np.ndarray, scores: np.ndarray) -> tuple[np.ndarray, float]:
    """The controller that the robot tries next, and its score: the best, or the most informative of the good ones.

    No estimation follows the last trial, so it is always given to the best.

    Args:
        job: inputs of the run.
        state: of the run.
        genomes: candidates (n, n_weights), best first.
        scores: minus their distances (n,), m; infinite where the simulation diverged.
    """
    settings, first = job.settings, float(scores[0])
    if not np.isfinite(first):
        raise InputError("every simulated walk diverged", where=job.simulator.robot.source, right="a smaller timestep")
    alternatives = state.alternatives[-1] if state.alternatives else ()
    if settings.next_trial == "farthest" or not alternatives or state.number >= settings.passes or first >= 0.0:
        return genomes[0], first
    candidates = np.flatnonzero(scores <= _NEARLY_AS_FAR * first)[:_MAX_CANDIDATES]
    share = state.probabilities[-1] or 0.0
    explanations = [(state.diagnoses[-1], share), *alternatives]
    remaining = remaining_probability(job.simulator, settings, genomes[candidates], explanations)
    index = candidates[most_informative(remaining)]
    return genomes[index], float(scores[index])


def _damage(job: Job, state: RunState) -> Iterator[RunState]:
    """Try the first controller before and after the damage; only the second trial is estimated from."""
    healthy = job.healthy if job.healthy is not None else SameTarget(job.simulator, ())
    before, damaged = _run_trial(job, healthy, state), _run_trial(job, job.target, state)
    yield replace(state, phase="estimation", number=1, before=before, trials=(damaged,))


def _estimate(job: Job, state: RunState) -> Iterator[RunState]:
    method = estimation_of(job.simulator, job.settings, state.number)
    healthy_trials = [] if job.healthy is None or state.before is None else [(state.controllers[0], state.before)]
    residuals = hypothesis_cost_of(job.simulator, job.settings, state.controllers, state.trials, healthy_trials)
    search = dict(state.search) if state.search is not None else method.begin(state.seeds)
    generation = sum(row.number == state.number and row.phase == "estimation" for row in state.history)
    while not method.done(search):
        search, generation = method.advance(search, residuals), generation + 1
        summary = method.summary(search)
        row = Row(state.number, "estimation", generation, summary.best, summary.median, summary.dominants)
        state = replace(state, search=search, history=(*state.history, row))
        if not method.done(search):
            yield state
    diagnosis = method.diagnosis(search)
    alternatives = tuple((changes_of(job.simulator, items), p) for items, p in diagnosis.alternatives)
    yield replace(
        state,
        phase="exploration",
        search=None,
        diagnoses=(*state.diagnoses, changes_of(job.simulator, diagnosis.items)),
        residuals=(*state.residuals, diagnosis.residual),
        probabilities=(*state.probabilities, diagnosis.probability),
        alternatives=(*state.alternatives, alternatives),
        alarms=(*state.alarms, diagnosis.alarm),
        seeds=(*state.seeds, method.seed(search)),
    )


def _trial(job: Job, state: RunState) -> Iterator[RunState]:
    trial = _run_trial(job, job.target, state)
    last = state.number >= job.settings.passes
    number = state.number if last else state.number + 1
    yield replace(state, phase="done" if last else "estimation", number=number, trials=(*state.trials, trial))


def _run_trial(job: Job, target: Target | RemoteTarget, state: RunState) -> Trial:
    """The trial of the last controller on a robot in the world."""
    weights, steps = state.controllers[-1], job.settings.steps
    controller = job.simulator.controller(weights, steps)
    if not isinstance(target, RemoteTarget):
        if isinstance(target, SameTarget | RealityGapTarget):
            return target(controller)
        return trial_of_result(target(controller), controller)
    changes = state.diagnoses[-1] if state.diagnoses else ()
    return target.perform(len(state.trials), controller, job.simulator.trial(changes, weights, steps))


def _row(number: int, phase: str, generation: int, values: Sequence[float] | np.ndarray, dominants: int) -> Row:
    return Row(number, phase, generation, float(values[0]), float(np.median(values)), dominants)
