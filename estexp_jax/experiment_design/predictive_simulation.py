"""Motions rehearsed by all rivals at once, and by variations of them that are no more than ordinary errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import final

import numpy as np

from estexp_jax.discovery.contest import Contest, Rival
from estexp_jax.discovery.hypotheses import parameters_only
from estexp_jax.errors import InputError, known
from estexp_jax.estimation.channels import Channels
from estexp_jax.estimation.windows import is_sensitive_to_start
from estexp_jax.experiment_design.separation import Limits, pairwise_separation, pairwise_separation_sensitive
from estexp_jax.physics.effects.base import NEVER
from estexp_jax.physics.effects.changes import Change, Values, encode, stack
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.engines.open_loop import OpenLoopRollout, OpenLoopSimulator
from estexp_jax.physics.model.clearance import without_collisions
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.physics.window import InitialState, Window, window_of

_ORDINARY = 0.03
"""Share by which a claimed effect's values may be off; of the model's own, `hypotheses` knows."""
_TIED = 0.1
"""Least probability that a rival counts with in a search if only its numbers make it improbable."""
_MOST_LANES = 1024
"""Lanes replayed together, to bound memory."""
_ROWS = 40
"""Of a motion that are searched for parts which come near each other."""


@final
@dataclass(frozen=True, eq=False)
class PredictedReadings:
    """What rivals do under some commands.

    Attributes:
        readings: (rivals, rows, channels).
        apart: (rivals, rivals) how far apart that is, in deviations; NaN where a simulation blew up.
        excess: how far any rival goes beyond limits, as of `Limits.excess`; above 1 where parts come near each other.
    """

    readings: np.ndarray
    apart: np.ndarray
    excess: float


@final
@dataclass(frozen=True, eq=False)
class PredictiveSimulation:
    """Rivals ready to be simulated.

    Attributes:
        replayer: of the robot and all effects of the rivals.
        channels: the readings compared.
        deviations: (channels,) what counts as one.
        probabilities: (rivals,).
        values: (rivals + variations, n_sites, n_parameters) for each effect.
        varied: (variations,) index of the rival that each is a variation of.
        timestep: longest step, s.
        whole: the robot, which the replayer may know without some contacts.
        apart: pairs of its bodies that the replayer lets through each other; no motion may bring them near.
        parting: whether the robot soon parts for good from one that differs a little, as robots on legs do.
        counted: robot steps simulated so far, a list of one number.
    """

    replayer: OpenLoopSimulator
    channels: Channels
    deviations: np.ndarray
    probabilities: np.ndarray
    values: Values
    varied: np.ndarray
    timestep: float
    whole: Robot
    apart: frozenset[tuple[int, int]] = frozenset()
    parting: bool = False
    counted: list[int] = field(default_factory=lambda: [0])

    @property
    def lanes(self) -> int:
        """Simulations of each motion."""
        return len(self.probabilities) + len(self.varied)

    def finer(self, parts: int) -> PredictiveSimulation:
        """The same at a part of the step."""
        return replace(self, timestep=self.timestep / parts)

    def shown(self, time: np.ndarray, commands: Sequence[np.ndarray], limits: Limits) -> list[PredictedReadings]:
        """What rivals do under each of some commands (rows, nu), from home, at rest."""
        lanes = self.lanes
        at_once = max(1, _MOST_LANES // lanes)
        found: list[PredictedReadings] = []
        for begin in range(0, len(commands), at_once):
            segments = [self._segment(time, c) for c in commands[begin : begin + at_once]]
            values = {name: np.tile(v, (len(segments), 1, 1)) for name, v in self.values.items()}
            replay = self.replayer.replay(values, segments, np.repeat(np.arange(len(segments)), lanes))
            self.counted[0] += lanes * sum(s.steps.n_steps for s in segments)
            each = [OpenLoopRollout(*(x[k * lanes : (k + 1) * lanes] for x in replay)) for k in range(len(segments))]
            found += [self._judged(part, limits) for part in each]
        return found

    def _segment(self, time: np.ndarray, commands: np.ndarray) -> Window:
        robot = self.replayer.robot
        model, rows = robot.model, len(time)
        sensor, qpos, qvel = (np.full((rows, n), np.nan) for n in (model.nsensordata, model.nq, model.nv))
        recording = Recording("proposed", time, commands, np.ones((rows, model.nu)), sensor, qpos, qvel)
        start = InitialState(robot.home(), np.zeros(model.nv))
        return window_of([recording], 0, (0, rows - 1), self.timestep, start)

    def _judged(self, replay: OpenLoopRollout, limits: Limits) -> PredictedReadings:
        n = len(self.probabilities)
        readings = self.channels.simulated(replay).astype(float)
        if not np.isfinite(readings).all():
            return PredictedReadings(readings[:n], np.full((n, n), np.nan), np.inf)
        scaled = readings / self.deviations
        measure = pairwise_separation_sensitive if self.parting else pairwise_separation
        apart = measure(scaled[:n], scaled[n:] - scaled[self.varied])
        excess = max(limits.excess(replay.qpos[:n], replay.qvel[:n]), self._touching(replay.qpos[0]))
        return PredictedReadings(readings[:n], apart, excess)

    def _touching(self, path: np.ndarray) -> float:
        """0 where the likeliest rival keeps all parts off each other along a path (rows, nq); else more than 1."""
        if not self.apart:
            return 0.0
        off = self.apart & set(without_collisions(self.whole, [path[:: max(1, len(path) // _ROWS)].astype(float)]))
        return 2.0 - len(off) / len(self.apart) if off < self.apart else 0.0


def predictive_simulation_of(
    replayer: OpenLoopSimulator, contest: Contest, whole: Robot | None = None, apart: Sequence[tuple[int, int]] = ()
) -> PredictiveSimulation:
    """Rivals and their ordinary variations, for a replayer that knows their effects.

    Variations are of the model's values under the first rival, because rivals differ little in what these do, and of
    each rival's own claims.

    Args:
        replayer: of the robot.
        contest: the rivals.
        whole: the robot with all its contacts; None: the replayer's.
        apart: see `PredictiveSimulation`.

    Raises:
        InputError: a channel or an effect's place is not one of the robot's.
    """
    robot = replayer.robot
    owner, varied = zip(*_variations(replayer, contest.rivals), strict=True)
    changes = [rival.changes for rival in contest.rivals] + [
        (*contest.rivals[i].changes, change) for i, change in zip(owner, varied, strict=True)
    ]
    values = stack([encode(robot, replayer.catalogue, some) for some in changes])
    channels = _channels(robot, contest.channels)
    deviations = np.where(contest.deviations > 0.0, contest.deviations, np.inf)  # unknown: it tells nothing
    shares = np.array([max(rival.probability, _TIED * rival.tied) for rival in contest.rivals])
    step = float(robot.model.opt.timestep)
    through = (robot if whole is None else whole, frozenset(apart))
    varied_of, soon = np.array(owner, int), is_sensitive_to_start(robot)
    return PredictiveSimulation(replayer, channels, deviations, shares, values, varied_of, step, *through, soon)


def _variations(replayer: OpenLoopSimulator, rivals: Sequence[Rival]) -> list[tuple[int, Change]]:
    """Index of a rival, and a change that adds an ordinary error to it."""
    free = parameters_only(replayer.robot, replayer.catalogue).free
    found = [(0, Change(f.effect, f.site or None, {f.parameter: f.neutral + f.spread})) for f in free]
    for i, rival in enumerate(rivals):
        own = {(f.effect, f.site) for f in free} - {(claim.effect, claim.name or "") for claim in rival.claims}
        for change in rival.changes:
            if (change.effect, change.name or "") not in own:
                found += [(i, c) for c in _errors(change)]
    return found


def _errors(change: Change) -> list[Change]:
    """Errors of a change's values; not of what names an element, or is out of reach."""
    known_ones = {p.name: p for p in effect(change.effect).parameters}
    found = []
    for name, value in change.parameters.items():
        p = known_ones[name]
        if not p.refers and 0.0 < abs(value) < NEVER:
            found.append(Change(change.effect, change.name, {name: p.neutral + _ORDINARY * value}))
    return found


def _channels(robot: Robot, names: Sequence[str]) -> Channels:
    """Channels by their names.

    Raises:
        InputError: the robot has no such reading.
    """
    columns = robot.sensor_columns()
    encoders = {f"qpos.{robot.names('joint')[j]}": int(robot.model.jnt_qposadr[j]) for j in robot.scalar_joints}
    for name in names:
        if name not in columns and name not in encoders:
            raise InputError(f"there is no reading '{name}'", where=robot.source, right=known([*columns, *encoders]))
    sensors = [columns.index(name) for name in names if name in columns]
    places = [encoders[name] for name in names if name not in columns]
    return Channels(tuple(names), np.array(sensors, int), np.array(places, int))
