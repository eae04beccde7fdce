"""Whether a log says what the robot did: columns exchanged, readings without a signal, clocks and commands displaced.

Each fault of logging that the registry knows is tried. Some are plain in the log itself; of the others the log is put
right as if it had the fault, and replayed by the nominal model. One is believed where that is far better than anything
that friction, inertia, masses and strengths of motors, all free, can make of the log as it is.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from estexp_jax.estimation.log_physics import NumberFit, fit_number, fit_physics
from estexp_jax.estimation.log_replay import LogReplay, log_replay_of
from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.effects.logging_fault import LoggingFault, Suspicion
from estexp_jax.physics.effects.registry import logging_faults
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording

_ROUNDS = 3
"""So many faults of one log are looked for by replays, one after the other."""
_LOUD = 2.0
"""An error of so many times what noise alone makes needs no reason."""
_PROMISING, _FAR_BETTER = 0.8, 0.5
"""Share of the log's error at which a fault is looked at closely, and of what physics leaves at which it counts."""
_AS_GOOD = 1.1
"""... or where it alone, one number, leaves no more than this times what all of physics leaves."""
_WORTH = 0.7
"""Physics is fitted beside a fault where that leaves less than this share of what the fault alone leaves."""
_CLOSELY = 3
"""So many faults are looked at closely at a time."""
_EVEN = 1.25
"""Where two assignments of columns to joints differ by less than this factor, nothing tells which is right."""


@final
@dataclass(frozen=True)
class FoundFault:
    """A fault of logging in one log.

    Attributes:
        change: the fault with its numbers.
        deviation: of its first number; 0 where it names an element, or was not fitted.
        before, after: error of the replayed log without and with it put right, as a share of the joints' ranges; NaN
            where the log itself shows it.
    """

    change: Change
    deviation: float = 0.0
    before: float = float("nan")
    after: float = float("nan")

    @property
    def probability(self) -> float:
        """The share of the squared error that it removes; 1 where the log itself shows it."""
        return 1.0 if np.isnan(self.before) else 1.0 - (self.after / self.before) ** 2


@final
@dataclass(frozen=True, eq=False)
class _Case:
    """Faults at once, each `(effect, suspicion)`."""

    faults: tuple[tuple[LoggingFault, Suspicion], ...]

    def mended(self, robot: Robot, recording: Recording, value: float = float("nan")) -> Recording:
        """The log without them, the first number of the first at a value where one is given."""
        for effect, (site, values) in self.faults:
            parameters = effect.values_of(values)
            if np.isfinite(value):
                parameters[effect.parameters[0].name] = value
            recording = effect.mended(robot, recording, site, parameters)
        return recording

    @property
    def looks_like_physics(self) -> bool:
        """Whether ordinary physics can stand in for it."""
        return any(effect.looks_like_physics(suspicion.site) for effect, suspicion in self.faults)

    @property
    def kind(self) -> tuple[str, str]:
        """What one of each is looked at closely of: a fault's numbers are sought, an exchange is as it is."""
        effect, suspicion = self.faults[0]
        return effect.name, suspicion.site if effect.is_continuous else str(self.faults)


def found_faults(
    robot: Robot, recording: Recording, names: Collection[str] | None = None, *, beside_physics: bool = True
) -> tuple[tuple[FoundFault, ...], Recording]:
    """The faults of logging that a recording shows, and the recording without those that are undone.

    Args:
        robot: the nominal one, with what is known of the recording.
        recording: the log.
        names: of the faults that are looked for; None: all.
        beside_physics: whether such as physics may hide are looked for as well, which takes seconds; of recordings of
            one recorder, one tells whether that is worth while.
    """
    effects = [e for e in logging_faults() if names is None or e.name in names]
    found = [*_plain(effects, robot, recording)]
    for one in found:
        recording = _undone(robot, recording, one)
    for _ in range(_ROUNDS):
        replay = log_replay_of(robot, recording)
        more = _by_replay(effects, robot, recording, replay, beside_physics) if replay is not None else ()
        if not more:
            break
        found += more
        before = recording
        for one in more:
            recording = _undone(robot, recording, one)
        if recording is before:
            break
    return tuple(found), recording


def untold_joints(robot: Robot, recording: Recording) -> list[tuple[str, ...]]:
    """Channels of which nothing in a recording tells to which of two joints they belong: each all that change places.

    Args:
        robot: the nominal one, with what is known of the recording.
        recording: the log.
    """
    replay = log_replay_of(robot, recording)
    if replay is None:
        return []
    cases = [_Case(tuple((e, s) for s in both)) for e in logging_faults() for both in e.tried_together(robot)]
    if not cases:
        return []
    errors = replay.errors([recording, *(case.mended(robot, recording) for case in cases)])
    least = max(_LOUD * replay.floor, errors[0])
    pairs = [case for case, error in zip(cases, errors[1:], strict=True) if error < _EVEN * least]
    return [tuple(suspicion.site for _, suspicion in case.faults) for case in pairs]


def _undone(robot: Robot, recording: Recording, found: FoundFault) -> Recording:
    effect = next(e for e in logging_faults() if e.name == found.change.effect)
    values = found.change.values
    return effect.mended(robot, recording, found.change.name or "", values) if effect.is_undone(values) else recording


def _plain(effects: Sequence[LoggingFault], robot: Robot, recording: Recording) -> Iterator[FoundFault]:
    for effect in effects:
        for site in effect.sites(robot):
            values = effect.plain(robot, site, recording)
            if values is not None:
                yield FoundFault(Change(effect.name, site or None, dict(values)))


def _by_replay(
    effects: Sequence[LoggingFault], robot: Robot, recording: Recording, replay: LogReplay, beside_physics: bool
) -> tuple[FoundFault, ...]:
    """The fault, or those that go together, without which the nominal model fits a log far better; () if none."""
    cases = [*_cases(effects, robot, recording)]
    if not cases:
        return ()
    errors = replay.errors([recording, *(case.mended(robot, recording) for case in cases)])
    whole, quiet = float(errors[0]), _LOUD * replay.floor
    if whole <= quiet:
        return ()
    best: dict[tuple[str, str], tuple[float, _Case]] = {}
    for error, case in sorted(zip(errors[1:].tolist(), cases, strict=True), key=lambda pair: pair[0]):
        best.setdefault(case.kind, (error, case))
    promising = [pair for pair in best.values() if pair[0] < _PROMISING * whole][:_CLOSELY]
    kinds = {case.kind for _, case in promising}
    hidden = [*_hidden_cases(effects, robot, recording, kinds)] if beside_physics else []
    if not promising and not hidden:
        return ()
    plain = fit_physics(replay, recording)
    if plain > quiet and hidden:
        beside = [fit_physics(replay, case.mended(robot, recording)) for case in hidden]
        if min(beside) < _PROMISING * plain:
            promising.append((float("inf"), hidden[int(np.argmin(beside))]))
    believed = list[tuple[float, _Case, NumberFit, float]]()
    for error, case in promising:
        alone = _closely(replay, robot, recording, case, as_modelled=True)
        by_itself = min(alone.error, error) < _FAR_BETTER * whole and alone.error <= max(_AS_GOOD * plain, quiet)
        is_enough = case.looks_like_physics or plain <= quiet
        is_enough = is_enough or fit_physics(replay, case.mended(robot, recording)) > _PROMISING * plain
        fit = alone if is_enough else _closely(replay, robot, recording, case)
        if fit.error < _FAR_BETTER * plain and fit.error < _WORTH * alone.error:
            believed.append((fit.error, case, fit, plain))
        elif by_itself:
            believed.append((alone.error, case, alone, whole))
    if not believed:
        return ()
    _, case, fit, before = min(believed, key=lambda each: max(each[0], replay.floor))
    return tuple(_found(effect, suspicion, fit, before) for effect, suspicion in case.faults)


def _cases(effects: Sequence[LoggingFault], robot: Robot, recording: Recording) -> Iterator[_Case]:
    for effect in effects:
        for site in effect.sites(robot):
            for values in effect.tried(robot, site, recording):
                yield _Case(((effect, Suspicion(site, values)),))
        for several in effect.tried_together(robot):
            yield _Case(tuple((effect, suspicion) for suspicion in several))


def _hidden_cases(
    effects: Sequence[LoggingFault], robot: Robot, recording: Recording, kinds: Collection[tuple[str, str]]
) -> Iterator[_Case]:
    """Faults that physics may hide, of other kinds than some."""
    for effect in effects:
        for site in effect.sites(robot):
            for values in effect.tried_beside_physics(robot, site, recording):
                case = _Case(((effect, Suspicion(site, values)),))
                if case.kind not in kinds:
                    yield case


def _closely(
    replay: LogReplay, robot: Robot, recording: Recording, case: _Case, *, as_modelled: bool = False
) -> NumberFit:
    """What a fault leaves, its number fitted: beside ordinary physics, or with the physics as it is modelled."""
    effect, (site, values) = case.faults[0]

    def error_at(value: float) -> float:
        version = case.mended(robot, recording, value)
        return float(replay.errors([version])[0]) if as_modelled else fit_physics(replay, version)

    if not effect.is_continuous:
        return NumberFit(error_at(float("nan")), float("nan"), 0.0)
    tried = sorted({v[0] for v in effect.tried(robot, site, recording)} | {effect.parameters[0].neutral})
    step = 0.9 * min(abs(n - values[0]) for n in tried if n != values[0])
    return fit_number(error_at, values[0], step, effect.bounds(robot, site)[0], replay.count)


def _found(effect: LoggingFault, suspicion: Suspicion, fit: NumberFit, before: float) -> FoundFault:
    site, values = suspicion
    parameters = effect.values_of(values)
    if effect.is_continuous:
        parameters[effect.parameters[0].name] = fit.value
    deviation = fit.deviation if effect.is_continuous else 0.0
    return FoundFault(Change(effect.name, site or None, parameters), deviation, before, fit.error)
