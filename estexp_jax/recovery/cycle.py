"""The estimation-exploration algorithm: walk, get damaged, diagnose from the sensors, walk again.

exploration -> damage, whose trial is the first recording -> `passes` times (estimation -> exploration -> hardware
trial).
A generator yields the state after every generation and every trial; any of them can be gone on with, bit for bit.

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
from estexp_jax.recovery.config import ROUGH, Settings
from estexp_jax.recovery.control.trial import Trial
from estexp_jax.recovery.estimation.base import changes_of
from estexp_jax.recovery.estimation.choice import estimation_of, hypothesis_cost_of
from estexp_jax.recovery.exploration.disagreement import most_informative, remaining_probability
from estexp_jax.recovery.exploration.explore import exploration_algorithm, exploration_score, rank_controllers
from estexp_jax.recovery.reality_gap_target import RealityGapTarget
from estexp_jax.recovery.simulator import DamageSimulator, damage_simulator
from estexp_jax.recovery.situations import situation
from estexp_jax.recovery.state import Row, RunState
from estexp_jax.recovery.target import RemoteTarget, SameTarget, Target
from estexp_jax.search.driver import evolve
from estexp_jax.search.genetic import Population

_GOOD, _CANDIDATES = 0.8, 48
"""Controllers that come at least this share of the best one's distance may be tried next, so many at most."""


@final
@dataclass(frozen=True, eq=False)
class Job:
    """What a run works with.

    Attributes:
        settings: of the run.
        simulator: the robot's, without damage.
        planted: what is wrong with the robot in the world, for the record; empty where nobody knows.
        target: the damaged robot.
        healthy: the robot before the damage; None where it cannot be had, and then the simulator stands in.
    """

    settings: Settings
    simulator: DamageSimulator
    planted: tuple[Change, ...]
    target: Target | RemoteTarget
    healthy: Target | RemoteTarget | None

    @property
    def stands_in(self) -> bool:
        """Whether what is told of the robot before the damage is the simulator's."""
        return self.healthy is None


def planted_changes(robot: Robot, settings: Settings) -> tuple[Change, ...]:
    """What a run's settings do to the robot.

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
    """Everything a run needs.

    Args:
        robot: the nominal robot.
        settings: of the run.
        target: the robot in the world, damaged already; None: a simulated one, with the damage of `settings`.
        healthy: with `target`, the same robot before the damage, where it can be had.
        world: a simulator of the robot with such settings, to be used again; its catalogue has to hold the damage.

    Raises:
        InputError: the damage cannot be planted, or the robot cannot be controlled or cannot travel.
    """
    if target is not None and settings.model_error is None:
        settings = replace(settings, model_error=ROUGH)
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
        job: what it works with.
        state: an earlier state of the same job, to go on from.

    Raises:
        InputError: every simulation of a phase blew up.
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
    weights, value = _chosen(job, state, *candidates)
    yield replace(
        state,
        phase="trial" if number else "damage",
        search=None,
        controllers=(*state.controllers, weights),
        simulated=(*state.simulated, -value),
    )


def _chosen(job: Job, state: RunState, genomes: np.ndarray, scores: np.ndarray) -> tuple[np.ndarray, float]:
    """The controller that the robot tries next, and its score: the best, or the most telling of those about as good.

    The last trial is for walking: nothing is learned from it.
    """
    settings, first = job.settings, float(scores[0])
    if not np.isfinite(first):
        raise InputError("every simulated walk blew up", where=job.simulator.robot.source, right="a smaller timestep")
    rivals = state.rivals[-1] if state.rivals else ()
    if settings.next_trial == "farthest" or not rivals or state.number >= settings.passes or first >= 0.0:
        return genomes[0], first
    good = np.flatnonzero(scores <= _GOOD * first)[:_CANDIDATES]
    share = state.probabilities[-1] or 0.0
    explanations = [(state.diagnoses[-1], share), *rivals]
    index = good[most_informative(remaining_probability(job.simulator, settings, genomes[good], explanations))]
    return genomes[index], float(scores[index])


def _damage(job: Job, state: RunState) -> Iterator[RunState]:
    """The first controller on the robot before and after; only the second is a recording."""
    healthy = job.healthy if job.healthy is not None else SameTarget(job.simulator, ())
    before, damaged = _performed(job, healthy, state), _performed(job, job.target, state)
    yield replace(state, phase="estimation", number=1, before=before, trials=(damaged,))


def _estimate(job: Job, state: RunState) -> Iterator[RunState]:
    method = estimation_of(job.simulator, job.settings, state.number)
    seen = [] if job.healthy is None or state.before is None else [(state.controllers[0], state.before)]
    residuals = hypothesis_cost_of(job.simulator, job.settings, state.controllers, state.trials, seen)
    search = dict(state.search) if state.search is not None else method.begin(state.seeds)
    generation = sum(row.number == state.number and row.phase == "estimation" for row in state.history)
    while not method.done(search):
        search, generation = method.advance(search, residuals), generation + 1
        told = method.summary(search)
        row = Row(state.number, "estimation", generation, told.best, told.median, told.dominants)
        state = replace(state, search=search, history=(*state.history, row))
        if not method.done(search):
            yield state
    diagnosis = method.diagnosis(search)
    yield replace(
        state,
        phase="exploration",
        search=None,
        diagnoses=(*state.diagnoses, changes_of(job.simulator, diagnosis.items)),
        residuals=(*state.residuals, diagnosis.residual),
        probabilities=(*state.probabilities, diagnosis.probability),
        rivals=(*state.rivals, tuple((changes_of(job.simulator, items), p) for items, p in diagnosis.rivals)),
        alarms=(*state.alarms, diagnosis.alarm),
        seeds=(*state.seeds, method.seed(search)),
    )


def _trial(job: Job, state: RunState) -> Iterator[RunState]:
    trial = _performed(job, job.target, state)
    last = state.number >= job.settings.passes
    number = state.number if last else state.number + 1
    yield replace(state, phase="done" if last else "estimation", number=number, trials=(*state.trials, trial))


def _performed(job: Job, target: Target | RemoteTarget, state: RunState) -> Trial:
    """The last controller on a robot in the world."""
    weights, steps = state.controllers[-1], job.settings.steps
    controller = job.simulator.controller(weights, steps)
    if not isinstance(target, RemoteTarget):
        return target(controller)
    changes = state.diagnoses[-1] if state.diagnoses else ()
    return target.perform(len(state.trials), controller, job.simulator.trial(changes, weights, steps))


def _row(number: int, phase: str, generation: int, values: Sequence[float] | np.ndarray, dominants: int) -> Row:
    return Row(number, phase, generation, float(values[0]), float(np.median(values)), dominants)
