"""The joint sparse fit: torques of short windows first, then readings of longer ones, all effects together."""

from __future__ import annotations

from collections.abc import Collection, Generator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, final

import numpy as np

from estexp_jax.discovery.fitting import Progress
from estexp_jax.discovery.joint.candidates import candidates, log_odds
from estexp_jax.discovery.joint.criteria import SelectionCriteria
from estexp_jax.discovery.joint.growth import Growth
from estexp_jax.discovery.joint.reading_stage import JointFit, cost_at, gauss_newton, without
from estexp_jax.discovery.joint.torque_stage import TorqueChoice, torque_choices
from estexp_jax.estimation.channels import Channels, channel_ranges
from estexp_jax.estimation.dataset import Dataset, dataset_of, evenly
from estexp_jax.estimation.linearised import independent_data, reading_noise_of
from estexp_jax.estimation.objective import Objective
from estexp_jax.estimation.parameters import ParameterSpace, Place, nuisances, parameter_space
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.engines.open_loop import OpenLoopSimulator
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.reading_noise import noise_std_of
from estexp_jax.physics.recording import Recording

_STEPS, _GROWTH_STEPS = 750_000, 5_000_000
"""Robot steps that one linearisation may take, and one of all candidates: windows are as many as that allows ..."""
_FEWEST, _MOST = 8, 240
"""... but at least and at most so many."""
_FEWEST_LONG, _MOST_LONG = 12, 64
"""Longer windows are taken only where there are so many, for held-out stretches to differ; and at most so many."""
_LENGTHS = (2.0, 1.0, 0.5, 0.25)
"""Lengths of the windows of the second stage, s: the first in which the simulator stays near the readings."""
_ROUNDS = 3
_GROWTHS = 6


@final
@dataclass(frozen=True, eq=False)
class JointProblem:
    """What the joint fit explains.

    Attributes:
        robots: the nominal robot with each recording's settings.
        recordings: with their roles; only training ones are used.
        channels: the readings compared.
        simulator: of the robot and the catalogue.
        places: what may be claimed.
        known: places whose values are given for each recording.
        observed: what recordings show of joints and sensors.
    """

    robots: Sequence[Robot]
    recordings: tuple[Recording, ...]
    channels: Channels
    simulator: OpenLoopSimulator
    places: Collection[Place]
    known: Collection[Place]
    observed: Observed

    def dataset(self, length: float, memory: float) -> Dataset:
        """All windows of a length of the training recordings, both in s as of `dataset_of`; each is cut once."""
        if (length, memory) not in self._datasets:
            cut = dataset_of(self.robots, self.recordings, self.channels, length, memory=memory)
            self._datasets[length, memory] = cut
        return self._datasets[length, memory]

    @cached_property
    def _datasets(self) -> dict[tuple[float, float], Dataset]:
        return {}


class JointResult(NamedTuple):
    """What the joint fit found.

    Attributes:
        torques: the first stage's choice.
        fit: the effects with their values.
        rivals: fits with another effect in place of one, which the recordings do not tell from it.
    """

    torques: TorqueChoice
    fit: JointFit
    rivals: tuple[JointFit, ...]


def joint_fit(
    problem: JointProblem, criteria: SelectionCriteria | None = None, fewest: int = 0
) -> Generator[Progress, None, JointResult]:
    """Fit all plausible effects together and keep those that the recordings call for.

    Args:
        problem: what is explained.
        criteria: what decides.
        fewest: with fewer effects than that after the readings' first fit, no more are looked for.

    Yields:
        Progress of each stage.
    """
    criteria = criteria or SelectionCriteria()
    space = parameter_space(problem.simulator.robot, problem.simulator.catalogue)
    errors = nuisances(space, problem.known)
    yield Progress("torque balance", 0, 1)
    tried = candidates(space, problem.observed, problem.places, additive=True)
    others = candidates(space, problem.observed, problem.places, additive=False)
    tried += [c.as_derivative() for c in others if effect(c.place[0]).model_attribute]
    data = problem.dataset(criteria.short_window, criteria.memory)
    data = evenly(data, _affordable(data, len(tried), _GROWTH_STEPS))
    objective = Objective(problem.simulator, space, data, states=True)
    added = [i for i in errors if effect(space.parameters[i].effect).additive]
    choices = torque_choices(objective, tried, added, problem.robots, criteria)
    fits, longest = list[JointFit](), data
    for k, first in enumerate(choices):
        point, places, fit = first.point, first.places, None
        for round_ in range(_ROUNDS):
            yield Progress("joint fit", k * _ROUNDS + round_, len(choices) * _ROUNDS)
            data = _windows(problem, space, point, len(errors) + 3 * len(places), criteria)
            fit = gauss_newton(objective.with_dataset(data), point, places, errors, _least_noise(problem), criteria)
            point, places = fit.point, fit.places
        assert fit is not None
        fits.append(fit)
        longest = max(longest, data, key=lambda d: float(np.median(d.durations)))
    common = objective.with_dataset(longest)
    best = _most_plausible(common, fits, _least_noise(problem), criteria) if len(fits) > 1 else 0
    if len(fits[best].places) < fewest:
        return JointResult(choices[best], fits[best], ())
    fit, rivals = yield from _grown(problem, objective, fits[best], errors, criteria)
    return JointResult(choices[best], fit, tuple(rivals))


def _most_plausible(
    objective: Objective, fits: Sequence[JointFit], least_noise: np.ndarray, criteria: SelectionCriteria
) -> int:
    """Index of the fit with the largest evidence, by Schwarz's criterion, on common windows."""
    data, space, points = objective.dataset, objective.space, np.array([f.point for f in fits])
    left = [reading_noise_of(data, simulated, least_noise, criteria.clip) for simulated in objective.simulate(points)]
    costs = cost_at(objective, points, np.min(left, axis=0), criteria)
    measured = np.isfinite(data.measurements).any(axis=1).sum(axis=1)
    count = float(independent_data(data, criteria.correlation_time) @ measured)
    numbers = np.array([sum(len(space.of_place[p]) for p in f.places) for f in fits])
    odds = np.array([-np.sum(log_odds(f.places, criteria, len(space.of_place))) for f in fits])
    return int(np.argmin(0.5 * count * costs + 0.5 * np.log(max(count, 1.0)) * numbers + odds))


def _grown(
    problem: JointProblem, objective: Objective, fit: JointFit, errors: list[int], criteria: SelectionCriteria
) -> Generator[Progress, None, tuple[JointFit, list[JointFit]]]:
    """The fit with what predicts held-out stretches better, and without what does not; and its rivals."""
    space, noise = objective.space, _least_noise(problem)
    every = [c for a in (True, False) for c in candidates(space, problem.observed, problem.places, additive=a)]
    # What is sinusoidal shows in torques as well as in readings.
    tried = [c.as_derivative() for c in every if not effect(c.place[0]).sinusoidal]
    for round_ in range(_GROWTHS):
        yield Progress("more effects", round_, _GROWTHS)
        directions = len(errors) + 3 * len(fit.places) + len(tried)
        data = _windows(problem, space, fit.point, directions, criteria, _GROWTH_STEPS)
        fitted = _windows(problem, space, fit.point, len(errors) + 3 * len(fit.places), criteria)
        few, many = objective.with_dataset(data), objective.with_dataset(fitted)
        more, tried = Growth(few, many, errors, noise, problem.observed, criteria).grown(fit, tried)
        if more is None:
            break
        fit = more
    data = _windows(problem, space, fit.point, len(errors) + 3 * len(fit.places), criteria)
    now = objective.with_dataset(data)
    judge = Growth(now, now, errors, noise, problem.observed, criteria)
    fit = gauss_newton(now, fit.point, fit.places, errors, noise, criteria)
    wrong = [p for p in judge.wrong_values(fit) if p in problem.places]
    if wrong:
        fit = gauss_newton(now, fit.point, [*fit.places, *wrong], errors, noise, criteria)
    kept = judge.needed(fit)
    point = without(space, fit, [p for p in fit.places if p not in kept])
    fit = gauss_newton(now, point, kept, errors, noise, criteria)
    yield Progress("rivals", 0, 1)
    return fit, judge.rivals(fit, tried)


def _affordable(data: Dataset, directions: int, most: float) -> int:
    """So many windows a linearisation can afford."""
    steps = max(w.steps.n_steps for w in data.windows)
    dofs = 2 * len(data.windows[0].start.qvel)
    return int(np.clip(most / (steps * (directions + dofs + 1)), _FEWEST, _MOST))


def values_only(
    problem: JointProblem, criteria: SelectionCriteria | None = None
) -> Generator[Progress, None, JointFit]:
    """Values of the model refitted within ordinary errors, and no effect.

    Yields:
        Progress.
    """
    criteria = criteria or SelectionCriteria()
    space = parameter_space(problem.simulator.robot, problem.simulator.catalogue)
    errors = nuisances(space, problem.known)
    yield Progress("values of the model alone", 0, 1)
    data = _windows(problem, space, space.neutral, len(errors), criteria)
    objective = Objective(problem.simulator, space, data)
    return gauss_newton(objective, space.neutral, (), errors, _least_noise(problem), criteria)


def _windows(
    problem: JointProblem,
    space: ParameterSpace,
    point: np.ndarray,
    directions: int,
    criteria: SelectionCriteria,
    steps: float = _STEPS,
) -> Dataset:
    """Windows as long as the simulator stays near the readings."""
    data = problem.dataset(_LENGTHS[-1], criteria.memory)
    for length in _LENGTHS:
        data = problem.dataset(length, criteria.memory)
        most = min(_affordable(data, directions, steps), _MOST_LONG)
        if length > _LENGTHS[-1] and min(len(data.windows), most) < _FEWEST_LONG:
            continue
        data = evenly(data, most)
        simulated = Objective(problem.simulator, space, data).simulate(point[None])[0]
        ranges = np.array([channel_ranges(problem.channels, problem.recordings[r]) for r in data.owner])
        error = (data.measurements - simulated) / ranges[:, None, :]
        if np.sqrt(np.nanmean(error**2)) < criteria.near:
            break
    return data


def _least_noise(problem: JointProblem) -> np.ndarray:
    """Noise (channels,) of the readings: the median of the training recordings'."""
    each = [
        [noise_std_of(r.time, column) for column in problem.channels.recorded(r).T]
        for r in problem.recordings
        if r.role == "train"
    ]
    spans = [channel_ranges(problem.channels, r) for r in problem.recordings if r.role == "train"]
    return np.fmax(np.nanmedian(np.array(each), axis=0), 1e-5 * np.nanmedian(np.array(spans), axis=0))
