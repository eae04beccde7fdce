"""The joint sparse fit: torques of short windows first, then readings of longer ones, all effects together."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple, final

import numpy as np

from estexp_jax.discovery.fitting import Progress
from estexp_jax.discovery.joint.candidates import Candidate, candidates, log_odds
from estexp_jax.discovery.joint.criteria import SelectionCriteria
from estexp_jax.discovery.joint.growth import Growth
from estexp_jax.discovery.joint.problem import JointProblem
from estexp_jax.discovery.joint.pruning import needed, wrong_values
from estexp_jax.discovery.joint.reading_stage import JointFit, cost_at, gauss_newton, without
from estexp_jax.discovery.joint.torque_stage import TorqueChoice, torque_choices
from estexp_jax.estimation.channels import channel_ranges
from estexp_jax.estimation.dataset import Dataset, evenly
from estexp_jax.estimation.linearised import independent_data, reading_noise_of
from estexp_jax.estimation.objective import Objective
from estexp_jax.estimation.parameters import ParameterSpace, Place, nuisances, parameter_space
from estexp_jax.physics.effects.registry import effect

_STEPS, _GROWTH_STEPS, _FIRST_STEPS = 2_500_000, 5_000_000, 800_000
"""Robot steps that one linearisation may take, one of all candidates, and one that others follow or that only compares:
windows are as many as that allows ..."""
_FEWEST, _MOST = 8, 240
"""... but at least and at most so many."""
_FEWEST_LONG, _MOST_LONG = 12, 240
"""Longer windows are taken only where there are so many, for held-out stretches to differ; and at most so many."""
_LENGTHS = (2.0, 1.0, 0.5, 0.25)
"""Lengths of the windows of the second stage, s: the first in which the simulator stays near the readings."""
_SHORTER = 0.6
"""Share of a window's length below which the next are where a step gained nothing: the next shorter of the lengths."""
_ROUNDS = 4
_GROWTHS = 6


class JointResult(NamedTuple):
    """What the torques choose, fitted to the readings.

    Attributes:
        torques: the first stage's choice.
        fit: the effects with their values.
    """

    torques: TorqueChoice
    fit: JointFit


@final
@dataclass(frozen=True, eq=False)
class JointSearch:
    """Fitting all plausible effects together, and keeping those that the recordings call for.

    Attributes:
        problem: what is explained.
        criteria: what decides.
    """

    problem: JointProblem
    criteria: SelectionCriteria = field(default_factory=SelectionCriteria)

    @cached_property
    def space(self) -> ParameterSpace:
        """All parameters."""
        return parameter_space(self.problem.simulator.robot, self.problem.simulator.catalogue)

    @cached_property
    def _errors(self) -> list[int]:
        """Indices of values of the model that may be a little off."""
        return nuisances(self.space, self.problem.known)

    def first(self) -> Generator[Progress, None, JointResult]:
        """What torques of short windows call for, fitted to readings.

        Yields:
            Progress of each stage.
        """
        problem, space, criteria = self.problem, self.space, self.criteria
        yield Progress("torque balance", 0, 1)
        tried = candidates(space, problem.observed, problem.places, additive=True)
        others = candidates(space, problem.observed, problem.places, additive=False)
        tried += [c.as_derivative() for c in others if effect(c.place[0]).model_attribute]
        data = problem.dataset(criteria.short_window, criteria.memory)
        data = evenly(data, _affordable(data, len(tried), _GROWTH_STEPS))
        plain = Objective(problem.simulator, space, data, states=True, counted=problem.counted)
        objective = plain.without_step_error(space.neutral, problem.lacking)
        added = [i for i in self._errors if effect(space.parameters[i].effect).additive]
        choices = torque_choices(objective, tried, added, problem.robots, criteria)
        fits, longest = list[JointFit](), data
        for k, chosen in enumerate(choices):
            point, places, fit, longest_now = chosen.point, chosen.places, None, np.inf
            for round_ in range(_ROUNDS):
                yield Progress("joint fit", k * _ROUNDS + round_, len(choices) * _ROUNDS)
                steps = _STEPS if round_ == _ROUNDS - 1 else _FIRST_STEPS
                data = self._windows(point, len(self._errors) + 3 * len(places), steps, longest_now)
                fit = self._fitted(data, point, places)
                if np.array_equal(fit.point, point):  # windows so long are not linear enough
                    longest_now = _SHORTER * float(np.median(data.durations))
                point, places = fit.point, fit.places
            assert fit is not None
            fits.append(fit)
            longest = max(longest, data, key=lambda d: float(np.median(d.durations)))
        best = self._most_plausible(longest, fits) if len(fits) > 1 else 0
        return JointResult(choices[best], fits[best])

    def grown(self, fit: JointFit) -> Generator[Progress, None, JointFit]:
        """A fit with what predicts held-out stretches better.

        Yields:
            Progress.
        """
        promising, about = list[Candidate](), None  # what gains on few windows, and the fit about which it does
        for round_ in range(_GROWTHS):
            yield Progress("more effects", round_, _GROWTHS)
            if about is None:
                promising, about = self._promising(fit), fit
            directions = len(self._errors) + 3 * len(fit.places) + len(promising)
            more = self._growth(self._windows(fit.point, directions), fit).grown(fit, promising)
            if more is None and about is fit:
                break
            fit, about = (fit, None) if more is None else (more, about)
        return fit

    def settled(self, fit: JointFit) -> JointFit:
        """A fit with values of the model that are far off, and without what held-out stretches contradict."""
        data = self._last_windows(fit)
        self._without_step_error.clear()  # what was right at the first guess is not exact where the search ends
        fit = self._fitted(data, fit.point, fit.places)
        judge = self._growth(data, fit)
        wrong = [p for p in wrong_values(judge, fit) if p in self.problem.places]
        if wrong:
            fit = self._fitted(data, fit.point, [*fit.places, *wrong])
        kept = needed(judge, fit)
        return self._fitted(data, without(self.space, fit, [p for p in fit.places if p not in kept]), kept)

    def rivals(self, fit: JointFit) -> Generator[Progress, None, list[JointFit]]:
        """Fits with another effect in place of one, which the recordings do not tell from it.

        Yields:
            Progress.
        """
        yield Progress("rivals", 0, 1)
        tried = self._candidates()
        instead = self._growth(self._few_windows(fit, tried), fit).replacements(fit, tried)
        directions = len(self._errors) + 3 * len(fit.places)
        return self._growth(self._windows(fit.point, directions, _FIRST_STEPS), fit).rivals(fit, instead)

    def values_only(self) -> Generator[Progress, None, JointFit]:
        """Values of the model refitted within ordinary errors, and no effect.

        Yields:
            Progress.
        """
        yield Progress("values of the model alone", 0, 1)
        neutral = self.space.neutral
        return self._fitted(self._windows(neutral, len(self._errors)), neutral, ())

    def _promising(self, fit: JointFit) -> list[Candidate]:
        """Of all candidates those that gain anything on few windows."""
        tried = self._candidates()
        return self._growth(self._few_windows(fit, tried), fit).promising(fit, tried)

    def _candidates(self) -> list[Candidate]:
        """Small changes by all effects at all places; of what is sinusoidal readings show no more than torques do."""
        problem, space = self.problem, self.space
        every = [c for a in (True, False) for c in candidates(space, problem.observed, problem.places, additive=a)]
        return [c.as_derivative() for c in every if not effect(c.place[0]).sinusoidal]

    def _few_windows(self, fit: JointFit, tried: Sequence[Candidate]) -> Dataset:
        return self._windows(fit.point, len(self._errors) + len(tried), _GROWTH_STEPS)

    def _growth(self, data: Dataset, fit: JointFit) -> Growth:
        noise, observed = self.problem.least_noise, self.problem.observed
        return Growth(self._objective(data, fit.point, fit.places), self._errors, noise, observed, self.criteria)

    def _objective(self, data: Dataset, point: np.ndarray, places: Sequence[Place]) -> Objective:
        """Of some windows, without the step's error as it is at the first point with effects at these places."""
        known, asked = self._without_step_error, (id(data), tuple(places))
        if asked not in known:
            plain = Objective(self.problem.simulator, self.space, data, counted=self.problem.counted)
            known[asked] = plain.without_step_error(point, self.problem.lacking)
        return known[asked]

    @cached_property
    def _without_step_error(self) -> dict[tuple[int, tuple[Place, ...]], Objective]:
        return {}

    def _fitted(self, data: Dataset, point: np.ndarray, places: Sequence[Place]) -> JointFit:
        objective = self._objective(data, point, places)
        return gauss_newton(objective, point, places, self._errors, self.problem.least_noise, self.criteria)

    def _most_plausible(self, data: Dataset, fits: Sequence[JointFit]) -> int:
        """Index of the fit with the largest evidence, by Schwarz's criterion, on common windows.

        Values of the model that are off by more than they usually are cost what their prior says.
        """
        criteria, space, points = self.criteria, self.space, np.array([f.point for f in fits])
        objective, least = self._objective(data, points[0], fits[0].places), self.problem.least_noise
        left = [reading_noise_of(data, simulated, least, criteria.clip) for simulated in objective.simulate(points)]
        costs = cost_at(objective, points, np.min(left, axis=0), criteria)
        measured = np.isfinite(data.measurements).any(axis=1).sum(axis=1)
        count = float(independent_data(data, criteria.correlation_time) @ measured)
        numbers = np.array([sum(len(space.of_place[p]) for p in f.places) for f in fits])
        odds = np.array([-np.sum(log_odds(f.places, criteria, space.robot, space.of_place, f.places)) for f in fits])
        unusual = np.array([self._unusual(f) for f in fits])
        return int(np.argmin(0.5 * count * costs + 0.5 * np.log(max(count, 1.0)) * numbers + odds + unusual))

    def _unusual(self, fit: JointFit) -> float:
        """What values of the model that a fit bends cost by their prior, nats."""
        bent = [i for i in self._errors if self.space.parameters[i].place not in fit.places]
        ordinary = self.criteria.model_error * np.array([self.space.parameters[i].nominal for i in bent])
        return 0.5 * float(np.sum(((fit.point - self.space.neutral)[bent] / ordinary) ** 2))

    def _last_windows(self, fit: JointFit) -> Dataset:
        return self._windows(fit.point, len(self._errors) + 3 * len(fit.places))

    @cached_property
    def _even_windows(self) -> dict[tuple[float, int], Dataset]:
        return {}

    def _windows(self, point: np.ndarray, directions: int, steps: float = _STEPS, longest: float = np.inf) -> Dataset:
        """Windows as long as the simulator stays near the readings, and not longer than so many s."""
        problem, criteria = self.problem, self.criteria
        data = problem.dataset(_LENGTHS[-1], criteria.memory)
        for length in [each for each in _LENGTHS if each <= max(longest, _LENGTHS[-1])]:
            data = problem.dataset(length, criteria.memory)
            most = min(_affordable(data, directions, steps), _MOST_LONG)
            if length > _LENGTHS[-1] and min(len(data.windows), most) < _FEWEST_LONG:
                continue
            data = self._even_windows.setdefault((length, most), evenly(data, most))
            plain = Objective(problem.simulator, self.space, data, counted=problem.counted)
            simulated = plain.simulate(point[None])[0]
            ranges = np.array([channel_ranges(problem.channels, problem.recordings[r]) for r in data.owner])
            error = (data.measurements - simulated) / ranges[:, None, :]
            if np.sqrt(np.nanmean(error**2)) < criteria.near:
                break
        return data


def _affordable(data: Dataset, directions: int, most: float) -> int:
    """So many windows a linearisation can afford."""
    steps = max(w.steps.n_steps for w in data.windows)
    dofs = 2 * len(data.windows[0].start.qvel)
    return int(np.clip(most / (steps * (directions + dofs + 1)), _FEWEST, _MOST))
