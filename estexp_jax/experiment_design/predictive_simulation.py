"""Simulation of proposed motions by all competing models, and by variations of these within ordinary errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import final

import numpy as np

from estexp_jax.discovery.competing_models import CompetingModel, CompetingModels
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

_ORDINARY_ERROR = 0.03
"""Relative error of a claimed effect's values; errors of the robot model's own values stand in `hypotheses`."""
_TIED_PROBABILITY = 0.1
"""Least probability of a model that predicts as well as the first but has more parameters."""
_MOST_LANES = 1024
"""Robots simulated together, to bound memory."""
_CONTACT_ROWS = 40
"""Rows of a motion that are checked for bodies in contact."""


@final
@dataclass(frozen=True, eq=False)
class PredictedReadings:
    """Predictions of the competing models for some commands.

    Attributes:
        readings: (models, rows, channels) in each channel's unit.
        separation: (models, models) in standard deviations; NaN if a simulation diverged.
        excess: largest violation of a limit by any model, as of `Limits.excess`; above 1 if bodies come into contact.
    """

    readings: np.ndarray
    separation: np.ndarray
    excess: float


@final
@dataclass(frozen=True, eq=False)
class PredictiveSimulation:
    """The competing models, ready to be simulated.

    Attributes:
        simulator: of the robot with all effects of the models.
        channels: the readings compared.
        deviations: (channels,) standard deviations of their noise, in each channel's unit.
        probabilities: (models,).
        values: (models + variations, n_sites, n_parameters) for each effect.
        variation_of: (variations,) index of the model that each is a variation of.
        timestep: longest physics step, s.
        full_robot: the robot with all contacts; the simulator's may lack some.
        unsimulated_contacts: pairs of its bodies whose contact the simulator lacks; no motion may bring them together.
        sensitive_to_start: whether small differences soon grow, as in robots on legs.
        robot_steps: robot steps simulated so far; a list of one number, as it is counted up.
    """

    simulator: OpenLoopSimulator
    channels: Channels
    deviations: np.ndarray
    probabilities: np.ndarray
    values: Values
    variation_of: np.ndarray
    timestep: float
    full_robot: Robot
    unsimulated_contacts: frozenset[tuple[int, int]] = frozenset()
    sensitive_to_start: bool = False
    robot_steps: list[int] = field(default_factory=lambda: [0])

    @property
    def lanes(self) -> int:
        """Number of simulations of each motion."""
        return len(self.probabilities) + len(self.variation_of)

    def finer(self, parts: int) -> PredictiveSimulation:
        """The same with a timestep divided by `parts`."""
        return replace(self, timestep=self.timestep / parts)

    def predict(self, time: np.ndarray, commands: Sequence[np.ndarray], limits: Limits) -> list[PredictedReadings]:
        """Predictions for each of some commands (rows, nu), from home at rest.

        Args:
            time: (rows,) s.
            commands: (rows, nu) each, in each actuator's unit.
            limits: that excesses are measured against.
        """
        lanes = self.lanes
        at_once = max(1, _MOST_LANES // lanes)
        found: list[PredictedReadings] = []
        for begin in range(0, len(commands), at_once):
            windows = [self._window(time, c) for c in commands[begin : begin + at_once]]
            values = {name: np.tile(v, (len(windows), 1, 1)) for name, v in self.values.items()}
            replay = self.simulator.replay(values, windows, np.repeat(np.arange(len(windows)), lanes))
            self.robot_steps[0] += lanes * sum(s.steps.n_steps for s in windows)
            each = [OpenLoopRollout(*(x[k * lanes : (k + 1) * lanes] for x in replay)) for k in range(len(windows))]
            found += [self._evaluate(part, limits) for part in each]
        return found

    def _window(self, time: np.ndarray, commands: np.ndarray) -> Window:
        robot = self.simulator.robot
        model, rows = robot.model, len(time)
        sensor, qpos, qvel = (np.full((rows, n), np.nan) for n in (model.nsensordata, model.nq, model.nv))
        recording = Recording("proposed", time, commands, np.ones((rows, model.nactuator)), sensor, qpos, qvel)
        start = InitialState(robot.home(), np.zeros(model.nv))
        return window_of([recording], 0, (0, rows - 1), self.timestep, start)

    def _evaluate(self, replay: OpenLoopRollout, limits: Limits) -> PredictedReadings:
        n = len(self.probabilities)
        readings = self.channels.simulated(replay).astype(float)
        if not np.isfinite(readings).all():
            return PredictedReadings(readings[:n], np.full((n, n), np.nan), np.inf)
        scaled = readings / self.deviations
        measure = pairwise_separation_sensitive if self.sensitive_to_start else pairwise_separation
        separation = measure(scaled[:n], scaled[n:] - scaled[self.variation_of])
        excess = max(limits.excess(replay.qpos[:n], replay.qvel[:n]), self._contact_excess(replay.qpos[0]))
        return PredictedReadings(readings[:n], separation, excess)

    def _contact_excess(self, path: np.ndarray) -> float:
        """0 if the likeliest model brings no bodies into contact along a path (rows, nq); else more than 1."""
        if not self.unsimulated_contacts:
            return 0.0
        rows = path[:: max(1, len(path) // _CONTACT_ROWS)].astype(float)
        free = self.unsimulated_contacts & set(without_collisions(self.full_robot, [rows]))
        return 2.0 - len(free) / len(self.unsimulated_contacts) if free < self.unsimulated_contacts else 0.0


def predictive_simulation_of(
    simulator: OpenLoopSimulator,
    competing: CompetingModels,
    full_robot: Robot | None = None,
    unsimulated_contacts: Sequence[tuple[int, int]] = (),
) -> PredictiveSimulation:
    """Prepare the competing models and their variations by ordinary errors.

    The robot model's own values are varied under the first model only, because their influence differs little between
    models. Each model's claims are varied under itself.

    Args:
        simulator: of the robot; its catalogue holds the models' effects.
        competing: the models.
        full_robot: the robot with all its contacts; None: the simulator's.
        unsimulated_contacts: see `PredictiveSimulation`.

    Raises:
        InputError: a channel or an effect's place is not one of the robot's.
    """
    robot = simulator.robot
    owner, errors = zip(*_variations(simulator, competing.models), strict=True)
    changes = [model.changes for model in competing.models] + [
        (*competing.models[i].changes, change) for i, change in zip(owner, errors, strict=True)
    ]
    values = stack([encode(robot, simulator.catalogue, some) for some in changes])
    channels = _channels(robot, competing.channels)
    deviations = np.where(competing.deviations > 0.0, competing.deviations, np.inf)  # unknown: no weight
    probabilities = np.array([max(model.probability, _TIED_PROBABILITY * model.tied) for model in competing.models])
    step = float(robot.model.opt.timestep)
    contacts = (robot if full_robot is None else full_robot, frozenset(unsimulated_contacts))
    variation_of, sensitive = np.array(owner, int), is_sensitive_to_start(robot)
    return PredictiveSimulation(
        simulator, channels, deviations, probabilities, values, variation_of, step, *contacts, sensitive
    )


def _variations(simulator: OpenLoopSimulator, models: Sequence[CompetingModel]) -> list[tuple[int, Change]]:
    """Index of a model, and a change that adds an ordinary error to it."""
    free = parameters_only(simulator.robot, simulator.catalogue).free
    found = [(0, Change(f.effect, f.site or None, {f.parameter: f.neutral + f.spread})) for f in free]
    for i, model in enumerate(models):
        own = {(f.effect, f.site) for f in free} - {(claim.effect, claim.name or "") for claim in model.claims}
        for change in model.changes:
            if (change.effect, change.name or "") not in own:
                found += [(i, c) for c in _errors(change)]
    return found


def _errors(change: Change) -> list[Change]:
    """Errors of a change's values, one at a time; not of references to elements, and not of infinite values."""
    known_ones = {p.name: p for p in effect(change.effect).parameters}
    found = []
    for name, value in change.parameters.items():
        p = known_ones[name]
        if not p.refers and 0.0 < abs(value) < NEVER:
            found.append(Change(change.effect, change.name, {name: p.neutral + _ORDINARY_ERROR * value}))
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
