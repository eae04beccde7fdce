"""Growing a joint fit: effects that torques of short windows do not settle, tried on its readings one at a time.

Gains, loads, delays, lags, gaps and faulty sensors are far from linear or share a scale with the masses, and relatives
of friction look alike in a balance of torques. Each is simulated at its first guesses beside the fit, and in place of
each of its effects; what predicts held-out stretches best is fitted with all the rest, and stays where readings agree.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from estexp_jax.discovery.joint.candidates import Candidate, derivatives, log_odds
from estexp_jax.discovery.joint.criteria import SelectionCriteria
from estexp_jax.discovery.joint.held_out import HeldOut, HeldOutGain
from estexp_jax.discovery.joint.proposals import Proposal, proposed
from estexp_jax.discovery.joint.reading_stage import STRETCHES, JointFit, cost_at, gauss_newton, within_bounds, without
from estexp_jax.estimation.linearised import independent_data, linearised, reading_noise_of
from estexp_jax.estimation.objective import Objective
from estexp_jax.estimation.parameters import Place
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import effect

_AT_ONCE = 4
"""So many effects are added about one linearisation, before the readings are simulated again."""
_RIVALS, _ROUNDS = 3, 1
"""So many rivals are fitted, in so many more steps than what is added."""
_FELT = 1e-12
"""Sum of squares of whitened readings from which on a candidate does anything at all."""
_PROMISING = 40
"""So many guesses that gain anything on few windows are tried on all."""
_ATTEMPTS = 3
"""So many sets of effects are tried about one linearisation before growth ends."""


@final
@dataclass(frozen=True, eq=False)
class Growth:
    """What a joint fit may grow by, and how that is judged.

    Attributes:
        objective: the windows on which candidates are tried and fits are made, without the error of the step.
        nuisances: indices of values of the model that may be a little off.
        least_noise: (channels,) noise of the readings.
        observed: what recordings show of joints and sensors.
        criteria: what decides.
    """

    objective: Objective
    nuisances: Sequence[int]
    least_noise: np.ndarray
    observed: Observed
    criteria: SelectionCriteria

    def promising(self, fit: JointFit, tried: Sequence[Candidate]) -> list[Candidate]:
        """Candidates that gain anything beside the fit or in place of one of its effects, the best first."""
        open_ = [c for c in tried if c.place not in fit.places]
        if not open_:
            return []
        held_out, base = self.held_out(fit, [c.direction for c in open_])
        felt = [i for i in range(len(open_)) if _is_felt(held_out, len(base) + i)]
        proposals = proposed(held_out, base, self.groups(fit), open_, felt, len(base))
        gaining = {id(p.candidate): p.candidate for p in proposals if p.gain.total > 0.0}
        return list(gaining.values())[:_PROMISING]

    def grown(self, fit: JointFit, tried: Sequence[Candidate]) -> JointFit | None:
        """The fit with more or other effects; None where none is better.

        Where what seemed best does not last once it is fitted, it is left out, and the next ones are tried.
        """
        open_ = [c for c in tried if c.place not in fit.places]
        if not open_:
            return None
        about = self.held_out(fit, [c.direction for c in open_])
        refused = set[Place]()
        for _ in range(_ATTEMPTS):
            chosen = self._chosen(about, fit, open_, refused)
            if not chosen:
                return None
            found = self._best(fit, chosen)
            if found is not None:
                return found
            refused.add(chosen[0].candidate.place)
        return None

    def _best(self, fit: JointFit, chosen: Sequence[Proposal]) -> JointFit | None:
        """The most plausible fit with all, some or the first of the proposals that held-out stretches confirm in it."""
        sets, found = [list(chosen), list(chosen[:1])][: len(chosen)], list[JointFit]()
        while sets:
            proposals = sets.pop(0)
            new = self._fitted(fit, proposals)
            kept = self._confirmed(fit, new)
            lasting = [p for p in proposals if p.candidate.place in kept]
            if len(lasting) == len(proposals):
                found.append(new)
            elif len(lasting) > 1:
                sets.insert(0, lasting)
        if not found:
            return None
        objective, data = self.objective, self.objective.dataset
        left = objective.simulate(fit.point[None])[0]
        noise = reading_noise_of(data, left, self.least_noise, self.criteria.clip)
        costs = cost_at(objective, np.array([fit.point, *(f.point for f in found)]), noise, self.criteria)
        measured = np.isfinite(data.measurements).any(axis=1).sum(axis=1)
        count = float(independent_data(data, self.criteria.correlation_time) @ measured)
        prices = [sum(self._price(fit, p) for p in f.places if p not in fit.places) for f in found]
        gains = 0.5 * count * (costs[0] - costs[1:]) - np.array(prices)
        best = int(np.argmax(gains))
        return found[best] if gains[best] > 0.0 else None

    def _confirmed(self, before: JointFit, fit: JointFit) -> list[Place]:
        """What came in and gains more than its price about the fit with it, too."""
        held_out, base = self.held_out(fit, [])
        groups, each = self.groups(fit), 0.5 * np.log(max(held_out.linear.observations, 1.0))
        new = [p for p in fit.places if p not in before.places]
        numbers = {p: len(self.objective.space.of_place[p]) for p in new}
        prices = {p: self._price(before, p) + each * numbers[p] for p in new}
        return [p for p in new if self.is_gain(held_out.gain_of(groups[p], base), prices[p])]

    def _price(self, fit: JointFit, place: Place, guesses: Mapping[Place, int] | None = None) -> float:
        """Prior log odds, nats, against an effect beside those of a fit; an effect's guesses share its odds."""
        space = self.objective.space
        odds = float(log_odds([place], self.criteria, space.robot, space.of_place, fit.places)[0])
        return float(np.log((guesses or {}).get(place, 1))) - odds

    def replacements(self, fit: JointFit, tried: Sequence[Candidate]) -> list[Proposal]:
        """The likeliest of all candidates in place of one of a fit's effects, each at its likeliest guess."""
        open_ = [c for c in tried if c.place not in fit.places]
        if not open_ or not fit.places:
            return []
        held_out, base = self.held_out(fit, [c.direction for c in open_])
        felt = [i for i in range(len(open_)) if _is_felt(held_out, len(base) + i)]
        proposals = proposed(held_out, base, self.groups(fit), open_, felt, len(base))
        others = [p for p in proposals if p.instead_of]
        first = {(p.instead_of, p.candidate.place): p for p in reversed(others)}
        likely = [p for p in others if first[p.instead_of, p.candidate.place] is p][:_RIVALS]
        # What does not help where the fit is may help elsewhere: it starts from a small amount.
        return [p._replace(gain=p.gain._replace(coefficient=p.gain.coefficient or 1.0)) for p in likely]

    def rivals(self, fit: JointFit, replacements: Sequence[Proposal]) -> list[JointFit]:
        """A fit with each of some replacements."""
        found = [self._fitted(fit, [p], prune=False) for p in replacements]
        for _ in range(_ROUNDS):  # they start as far away as what they lack
            found = [self._step(f.point, f.places, prune=False) for f in found]
        return found

    def _is_seen(self, proposal: Proposal) -> bool:
        """Whether recordings show enough to tell an effect of the size proposed."""
        place, change = proposal.candidate.place, proposal.candidate.at(proposal.gain.coefficient)
        return bool(change.any()) and self.is_identifiable(place, self.objective.space.neutral + change)

    def is_identifiable(self, place: Place, point: np.ndarray) -> bool:
        """Whether recordings show enough to tell an effect with its values at a point (n,)."""
        space = self.objective.space
        values = {space.parameters[i].name: float(point[i]) for i in space.of_place[place]}
        return effect(place[0]).identifiable(space.robot, place[1], values, self.observed)

    def _chosen(
        self, about: tuple[HeldOut, np.ndarray], fit: JointFit, open_: Sequence[Candidate], refused: Collection[Place]
    ) -> list[Proposal]:
        """Effects to be added, one after the other about one linearisation with all candidates that are open."""
        held_out, base = about
        first, groups, chosen = len(base), self.groups(fit), list[Proposal]()
        guesses = Counter(c.place for c in open_)
        for _ in range(_AT_ONCE):
            taken = {*refused, *(p.candidate.place for p in chosen)}
            felt = [i for i, c in enumerate(open_) if c.place not in taken and _is_felt(held_out, first + i)]
            proposals = proposed(held_out, base, groups, open_, felt, first)
            priced = [(p, p.price + self._price(fit, p.candidate.place, guesses)) for p in proposals]
            priced.sort(key=lambda both: both[1] - both[0].gain.total)
            best = next((p for p, price in priced if self.is_gain(p.gain, price) and self._is_seen(p)), None)
            if best is None:
                break
            chosen.append(best)
            if best.instead_of:
                base = np.setdiff1d(base, groups.pop(best.instead_of))
            base = np.append(base, first + next(i for i, c in enumerate(open_) if c is best.candidate))
        return chosen

    def is_gain(self, gain: HeldOutGain, price: float) -> bool:
        """Whether a held-out gain is more than its price, and so but for a chance."""
        return gain.least(self.criteria.chance) > price

    def _fitted(self, fit: JointFit, proposals: Sequence[Proposal], *, prune: bool = True) -> JointFit:
        gone = [p.instead_of for p in proposals if p.instead_of]
        space = self.objective.space
        point = without(space, fit, gone)
        point = within_bounds(space, point + sum(p.candidate.at(p.gain.coefficient) for p in proposals))
        places = [*(q for q in fit.places if q not in gone), *(p.candidate.place for p in proposals)]
        return self._step(point, places, prune=prune)

    def _step(self, point: np.ndarray, places: Sequence[Place], *, prune: bool = True) -> JointFit:
        least = self.least_noise
        return gauss_newton(self.objective, point, places, self.nuisances, least, self.criteria, prune=prune)

    def free(self, fit: JointFit) -> list[int]:
        """Indices of a fit's own parameters, and of the model's values that may be a little off."""
        own = [int(i) for place in fit.places for i in self.objective.space.of_place[place]]
        return [*own, *(i for i in self.nuisances if i not in own)]

    def n_nuisances(self, fit: JointFit) -> int:
        """How many of these are the latter."""
        return len(self.free(fit)) - sum(len(self.objective.space.of_place[p]) for p in fit.places)

    def groups(self, fit: JointFit) -> dict[Place, np.ndarray]:
        """Positions of each place's columns among those of the fit."""
        position = {i: k for k, i in enumerate(self.free(fit))}
        return {p: np.array([position[int(i)] for i in self.objective.space.of_place[p]]) for p in fit.places}

    def held_out(self, fit: JointFit, more: Sequence[np.ndarray]) -> tuple[HeldOut, np.ndarray]:
        """Windows about a fit with its own parameters, nuisances, and more directions; and the first two's columns."""
        objective, criteria = self.objective, self.criteria
        space = objective.space
        free = derivatives(space, fit.point, self.free(fit))
        directions = np.concatenate([free.directions, np.reshape(more, (len(more), len(fit.point)))])
        found = objective.responses(fit.point, directions)
        noise = reading_noise_of(objective.dataset, found.point, self.least_noise, criteria.clip)
        linear = linearised(objective.dataset, found, noise, criteria.correlation_time, criteria.clip)
        offset = (fit.point - space.neutral)[free.indices] / free.steps
        base = np.arange(len(free.indices))
        nominal = np.array([space.parameters[i].nominal for i in free.indices])
        claimed = base < len(base) - self.n_nuisances(fit)
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
