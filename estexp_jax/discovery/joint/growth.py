"""Growing a joint fit: effects that torques of short windows do not settle, tried on its readings one at a time.

Gains, loads, delays, lags, gaps and faulty sensors are far from linear or share a scale with the masses, and relatives
of friction look alike in a balance of torques, so that they are not offered all at once. Each is simulated at its first
guesses beside the fit, and in place of each of its effects; what predicts held-out stretches best is fitted with all
the rest, and stays where the readings agree.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from estexp_jax.discovery.joint.candidates import Candidate, derivatives
from estexp_jax.discovery.joint.criteria import SelectionCriteria
from estexp_jax.discovery.joint.held_out import HeldOut, HeldOutGain
from estexp_jax.discovery.joint.proposals import Proposal, proposed
from estexp_jax.discovery.joint.reading_stage import STRETCHES, JointFit, cost_at, gauss_newton, without
from estexp_jax.estimation.linearised import independent_data, linearised, reading_noise_of
from estexp_jax.estimation.objective import Objective
from estexp_jax.estimation.parameters import Place
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import effect

_AT_ONCE = 4
"""So many effects are added about one linearisation, before the readings are simulated again."""
_RIVALS = 3
"""So many rivals are fitted."""
_FELT = 1e-12
"""Sum of squares of whitened readings from which on a candidate does anything at all."""
_LOOKED_AT_AGAIN = 40
"""So many guesses are tried again beside what was added."""


@final
@dataclass(frozen=True, eq=False)
class Growth:
    """What a joint fit may grow by, and how that is judged.

    Attributes:
        objective: the windows on which candidates are tried.
        fitted: those, more of them, on which a fit is made.
        nuisances: indices of values of the model that may be a little off.
        least_noise: (channels,) noise of the readings.
        observed: what recordings show of joints and sensors.
        criteria: what decides.
    """

    objective: Objective
    fitted: Objective
    nuisances: Sequence[int]
    least_noise: np.ndarray
    observed: Observed
    criteria: SelectionCriteria

    def grown(self, fit: JointFit, tried: Sequence[Candidate]) -> tuple[JointFit | None, list[Candidate]]:
        """The fit with more or other effects, None where none is better; and what may be tried again."""
        chosen, again = self._chosen(fit, tried)
        if not chosen:
            return None, again
        several = [chosen, chosen[:1]] if len(chosen) > 1 else [chosen]
        found = [self._fitted(fit, proposals) for proposals in several]
        kept = [k for k, f in enumerate(found) if self._is_confirmed(fit, f, tried)]
        if not kept:
            return None, again
        several, found = [several[k] for k in kept], [found[k] for k in kept]
        data, at = self.fitted.dataset, fit.point[None]
        noise = reading_noise_of(data, self.fitted.simulate(at)[0], self.least_noise, self.criteria.clip)
        costs = cost_at(self.fitted, np.array([fit.point, *(f.point for f in found)]), noise, self.criteria)
        independent = independent_data(data, self.criteria.correlation_time)
        count = float(independent @ np.isfinite(data.measurements).any(axis=1).sum(axis=1))
        gains = 0.5 * count * (costs[0] - costs[1:]) - _price(tried, self.criteria) * np.array(list(map(len, several)))
        best = int(np.argmax(gains))
        return found[best] if gains[best] > 0.0 else None, again

    def _is_confirmed(self, before: JointFit, fit: JointFit, tried: Sequence[Candidate]) -> bool:
        """Whether what came in gains more than its price about the fit with it, too."""
        judge = replace(self, objective=self.fitted)
        held_out, base = judge._held_out(fit, [])
        groups, each = self._groups(fit), 0.5 * np.log(max(held_out.linear.observations, 1.0))
        prices = {c.place: _price(tried, self.criteria) + each * c.numbers for c in tried}
        new = [p for p in fit.places if p not in before.places]
        return all(self.is_gain(held_out.gain_of(groups[p], base), prices[p]) for p in new)

    def rivals(self, fit: JointFit, tried: Sequence[Candidate]) -> list[JointFit]:
        """Fits with another effect in place of one, which held-out stretches do not tell from it."""
        open_ = [c for c in tried if c.place not in fit.places]
        if not open_ or not fit.places:
            return []
        held_out, base = self._held_out(fit, [c.direction for c in open_])
        felt = [i for i in range(len(open_)) if _is_felt(held_out, len(base) + i)]
        proposals = proposed(held_out, base, self._groups(fit), open_, felt, len(base))
        alike = [p for p in proposals if p.instead_of and p.gain.coefficient and self._is_alike(p.gain)]
        first = {(p.instead_of, p.candidate.place): p for p in reversed(alike)}
        found = [self._fitted(fit, [p]) for p in list(first.values())[::-1][:_RIVALS]]
        return [f for f in found if set(f.places) != set(fit.places)]

    def _is_seen(self, proposal: Proposal) -> bool:
        """Whether recordings show enough to tell an effect of the size proposed."""
        place, change = proposal.candidate.place, proposal.candidate.at(proposal.gain.coefficient)
        return bool(change.any()) and self._is_identifiable(place, self.objective.space.neutral + change)

    def _is_identifiable(self, place: Place, point: np.ndarray) -> bool:
        space = self.objective.space
        values = {space.parameters[i].name: float(point[i]) for i in space.of_place[place]}
        return effect(place[0]).identifiable(space.robot, place[1], values, self.observed)

    def _is_alike(self, gain: HeldOutGain) -> bool:
        return gain.least(1.0 - self.criteria.chance) > 0.0

    def _chosen(self, fit: JointFit, tried: Sequence[Candidate]) -> tuple[list[Proposal], list[Candidate]]:
        """Effects to be added, one after the other about one linearisation; and the candidates that gain anything."""
        open_ = [c for c in tried if c.place not in fit.places]
        if not open_:
            return [], []
        held_out, base = self._held_out(fit, [c.direction for c in open_])
        first, groups, chosen = len(base), self._groups(fit), list[Proposal]()
        again = list[Candidate]()
        for _ in range(_AT_ONCE):
            taken = {p.candidate.place for p in chosen}
            left = [i for i, c in enumerate(open_) if c.place not in taken]
            felt = [i for i in left if _is_felt(held_out, first + i)]
            proposals = proposed(held_out, base, groups, open_, felt, first)
            if not chosen:
                gaining = {id(p.candidate): p.candidate for p in proposals if p.gain.total > 0.0}
                again = list(gaining.values())[:_LOOKED_AT_AGAIN]
            price = _price(tried, self.criteria)
            best = next((p for p in proposals if self.is_gain(p.gain, price + p.price) and self._is_seen(p)), None)
            if best is None:
                break
            chosen.append(best)
            if best.instead_of:
                base = np.setdiff1d(base, groups.pop(best.instead_of))
            base = np.append(base, first + next(i for i, c in enumerate(open_) if c is best.candidate))
        return chosen, again

    def needed(self, fit: JointFit) -> tuple[Place, ...]:
        """The places of a fit without those that held-out stretches contradict."""
        places = [p for p in fit.places if self._is_identifiable(p, fit.point)]
        held_out, base = self._held_out(fit, [])
        groups = self._groups(fit)
        base = np.setdiff1d(base, np.concatenate([np.zeros(0, int), *(groups[p] for p in {*fit.places} - {*places})]))

        def gain(place: Place) -> float:
            return held_out.gain_of(groups[place], base).in_errors

        weak = [p for p in places if gain(p) <= self.criteria.kept_errors]
        while weak and gain(worst := min(weak, key=gain)) <= self.criteria.kept_errors:
            weak.remove(worst)
            places.remove(worst)
            base = np.setdiff1d(base, groups[worst])
        return tuple(places)

    def wrong_values(self, fit: JointFit) -> tuple[Place, ...]:
        """Values of the model that the fit moved farther than they are usually off, where held-out stretches agree."""
        space, free = self.objective.space, self._free(fit)
        held_out, base = self._held_out(fit, [])
        found = []
        for k, i in enumerate(free[len(free) - self._n_nuisances(fit) :], len(free) - self._n_nuisances(fit)):
            p = space.parameters[i]
            off = abs(fit.point[i] - p.neutral) / (self.criteria.model_error * p.nominal)
            if off > self.criteria.wrong_value and self.is_gain(held_out.gain_of([k], base), 0.0):
                found.append(p.place)
        return tuple(found)

    def is_gain(self, gain: HeldOutGain, price: float) -> bool:
        """Whether a held-out gain is more than its price, and so but for a chance."""
        return gain.least(self.criteria.chance) > price

    def _fitted(self, fit: JointFit, proposals: Sequence[Proposal]) -> JointFit:
        gone = [p.instead_of for p in proposals if p.instead_of]
        point = without(self.objective.space, fit, gone)
        point = point + sum(p.candidate.at(p.gain.coefficient) for p in proposals)
        places = [*(q for q in fit.places if q not in gone), *(p.candidate.place for p in proposals)]
        return gauss_newton(self.fitted, point, places, self.nuisances, self.least_noise, self.criteria)

    def _free(self, fit: JointFit) -> list[int]:
        own = [int(i) for place in fit.places for i in self.objective.space.of_place[place]]
        return [*own, *(i for i in self.nuisances if i not in own)]

    def _n_nuisances(self, fit: JointFit) -> int:
        return len(self._free(fit)) - sum(len(self.objective.space.of_place[p]) for p in fit.places)

    def _groups(self, fit: JointFit) -> dict[Place, np.ndarray]:
        """Positions of each place's columns among those of the fit."""
        position = {i: k for k, i in enumerate(self._free(fit))}
        return {p: np.array([position[int(i)] for i in self.objective.space.of_place[p]]) for p in fit.places}

    def _held_out(self, fit: JointFit, more: Sequence[np.ndarray]) -> tuple[HeldOut, np.ndarray]:
        """Windows about a fit with its own parameters, nuisances, and more directions; and the first two's columns."""
        objective, criteria = self.objective, self.criteria
        space = objective.space
        free = derivatives(space, fit.point, self._free(fit))
        directions = np.concatenate([free.directions, np.reshape(more, (len(more), len(fit.point)))])
        found = objective.responses(fit.point, directions)
        noise = reading_noise_of(objective.dataset, found.point, self.least_noise, criteria.clip)
        linear = linearised(objective.dataset, found, noise, criteria.correlation_time, criteria.clip)
        offset = (fit.point - space.neutral)[free.indices] / free.steps
        base = np.arange(len(free.indices))
        nominal = np.array([space.parameters[i].nominal for i in free.indices])
        claimed = base < len(base) - self._n_nuisances(fit)
        precision = (free.steps / np.where(claimed, np.inf, criteria.model_error * nominal)) ** 2
        held_out = HeldOut(
            linear,
            linear.residual + linear.columns[:, base] @ offset,
            np.concatenate([precision, np.zeros(len(more))]),
            STRETCHES,
            linear.observations / max(len(objective.dataset.windows), 1),
            criteria.freedom,
        )
        return held_out, base


def _is_felt(held_out: HeldOut, column: int) -> bool:
    return bool(np.sum(held_out.linear.columns[:, column] ** 2) > _FELT)


def _price(tried: Sequence[Candidate], criteria: SelectionCriteria) -> float:
    """Prior log odds, nats, against any one place of all that were tried."""
    return float(np.log(max(len({c.place for c in tried}) / criteria.expected_effects, 1.0)))
