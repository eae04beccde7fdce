"""Design of the next experiment: the motion within limits on which competing models disagree most."""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import final

import mujoco
import numpy as np

from estexp_jax.discovery.competing_models import CompetingModels
from estexp_jax.discovery.fitting import Progress
from estexp_jax.discovery.hypotheses import model_values
from estexp_jax.errors import InputError
from estexp_jax.experiment_design.predictive_simulation import (
    PredictedReadings,
    PredictiveSimulation,
    predictive_simulation_of,
)
from estexp_jax.experiment_design.separation import (
    GENES,
    Limits,
    decode_commands,
    limits_of,
    random_motion,
    separation_score,
)
from estexp_jax.physics.effects.registry import catalogue
from estexp_jax.physics.engines.choice import open_loop_simulator
from estexp_jax.physics.model.actuators import actuator_of_input
from estexp_jax.physics.model.clearance import without_collisions
from estexp_jax.physics.model.robot import Robot
from estexp_jax.search.driver import evolve
from estexp_jax.search.genetic import Genetic, Population

_SLOWEST_ROWS, _FASTEST_ROWS = 20.0, 200.0
"""Bounds of the rate of proposed commands, Hz."""
_FINALISTS, _RANDOM = 4, 8
"""Numbers of best and of random commands that are simulated at the fine step in the end."""
_WORK, _FEWEST = 12_000_000, 12
"""Robot steps of a search at most, and motions in a generation at least."""
CLEAR_SEPARATION = 3.0
"""Separation, in standard deviations, from which on two models can clearly be distinguished."""
LIMIT_TOLERANCE = 0.02
"""Violation of a limit, as of `Limits.excess`, that is tolerated at the fine step."""
_STRENGTHS = (0.9, 0.5, 0.25, 0.12, 0.06, 0.03)
"""Strengths at which random motions are tried, as shares of the range of commands."""
_MUTATION = 0.15
"""Probability of a mutation; high, because genomes are short and few are tried."""


@final
@dataclass(frozen=True)
class ProposeConfig:
    """Settings of the search for a separating motion.

    Attributes:
        duration: of the motion, s.
        margin: share of each range of command, joint and force that may be used.
        speed: largest joint speed, as a multiple of that in the recordings.
        seed: of the search.
        engine: auto, lanes, c or mjx.
        population: motions in a generation at most.
        generations: of the search.

    Raises:
        InputError: a number is out of range.
    """

    duration: float = 8.0
    margin: float = 0.9
    speed: float = 3.0
    seed: int = 0
    engine: str = "auto"
    population: int = 48
    generations: int = 16

    def __post_init__(self) -> None:
        for name, low, high in (("duration", 1.0, 600.0), ("margin", 0.01, 1.0), ("speed", 0.01, 1e6)):
            value = getattr(self, name)
            if not low <= value <= high:
                raise InputError(f"{value} makes no sense", where=f"--{name}", right=f"{low:g} to {high:g}")
        if self.seed < 0:
            raise InputError(f"{self.seed} is no seed", where="--seed", right="0 or more")


@final
@dataclass(frozen=True, eq=False)
class ProposedExperiment:
    """A motion to record, and what each competing model predicts for it.

    Attributes:
        robot: the nominal one.
        competing_models: the models.
        config: settings of the search.
        time: (rows,) s.
        commands: (rows, nu) in each actuator's unit.
        predicted: predictions of the models for these commands.
        random_separation: (models, models) median separation by random motions of the same length and limits.
        robot_steps: robot steps simulated.
        engine: its name, and the reason for its choice.
    """

    robot: Robot
    competing_models: CompetingModels
    config: ProposeConfig
    time: np.ndarray
    commands: np.ndarray
    predicted: PredictedReadings
    random_separation: np.ndarray
    robot_steps: int
    engine: tuple[str, str]


def search_experiment(
    robot: Robot, competing: CompetingModels, finer: int, config: ProposeConfig
) -> Generator[Progress, None, ProposedExperiment]:
    """Search for the motion that separates the competing models most.

    Motions are evolved at the model's own step. The best ones, and random ones for comparison, are then simulated at
    the fine step at which explanations were fitted. The robot begins at home at rest. Effects act from the beginning,
    even if they began part-way through the recordings. Bodies that do not touch at home must not touch later. Errors
    of the initial state are neglected: it will be measured, and servos soon remove its influence.

    Args:
        robot: the nominal one.
        competing: at least two models.
        finer: the final simulation's timestep is the model's own divided by this.
        config: settings of the search.

    Yields:
        Progress.

    Returns:
        The best motion found.

    Raises:
        InputError: there are fewer than two models or no actuators, or no engine simulates the robot.
    """
    yield Progress("preparing", 0, 1, f"{len(competing.models)} explanations")
    simulation = _simulation(robot, competing, config)
    speeds = config.speed * np.where((competing.speeds > 0.0) & ~_unlimited(robot, competing), competing.speeds, np.inf)
    limits, time = limits_of(robot, config.margin, competing.commands, speeds), _clock(competing, config)
    population = _population(simulation, time, config)
    genetic = Genetic(GENES * robot.model.nu, population, config.seed, mutation=_MUTATION)
    final: Population | None = None
    for final in evolve(genetic, _score(simulation, limits, time), config.generations):
        yield Progress("searching motions", final.generation, config.generations, _note(float(final.scores[0])))
    yield Progress("judging the best", 0, 1)
    finalists = [] if final is None else list(dict.fromkeys(tuple(g) for g in final.genomes.tolist()))[:_FINALISTS]
    motions = [decode_commands(limits, time, np.array(g)) for g in finalists]
    random_commands = _random(simulation, limits, time, config.seed)
    predicted = simulation.finer(finer).predict(time, motions + random_commands, limits)
    best = min(range(len(predicted)), key=lambda i: _cost(predicted[i], simulation, LIMIT_TOLERANCE))
    random_separation = np.median([np.nan_to_num(p.separation) for p in predicted[len(motions) :]], axis=0)
    engine, reason, _ = simulation.simulator.choice
    steps, choice = simulation.robot_steps[0], (engine, reason)
    commands = (motions + random_commands)[best]
    return ProposedExperiment(
        robot, competing, config, time, commands, predicted[best], random_separation, steps, choice
    )


def _unlimited(robot: Robot, competing: CompetingModels) -> np.ndarray:
    """Degrees of freedom (nv,) whose recorded speed is no limit.

    These are joints whose motors had a constant command, and those of a floating base, which is not actuated.
    """
    model, held = robot.model, np.zeros(robot.model.nv, dtype=bool)
    for joint in np.flatnonzero(model.jnt_type == int(mujoco.mjtJoint.mjJNT_FREE)).tolist():
        held[model.jnt_dofadr[joint] : model.jnt_dofadr[joint] + 6] = True
    joints = (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT))
    for a, (low, high) in zip(actuator_of_input(model), competing.commands, strict=True):
        if low == high and int(model.actuator_trntype[a]) in joints:
            held[model.jnt_dofadr[model.actuator_trnid[a, 0]]] = True
    return held


def _random(simulation: PredictiveSimulation, limits: Limits, time: np.ndarray, seed: int) -> list[np.ndarray]:
    """Commands (rows, nu) of random motions, each at the largest strength within limits, or at the least."""
    found = []
    for k in range(_RANDOM):
        motions = [random_motion(limits, time, strength, seed + k) for strength in _STRENGTHS]
        within = [c for c, p in zip(motions, simulation.predict(time, motions, limits), strict=True) if p.excess <= 0.0]
        found.append((within or motions[-1:])[0])
    return found


def _simulation(robot: Robot, competing: CompetingModels, config: ProposeConfig) -> PredictiveSimulation:
    if len(competing.models) < 2:
        raise InputError("there are fewer than two explanations to tell apart", where=robot.source)
    if robot.model.nu == 0:
        raise InputError("the robot has no actuators, so no motion can be proposed", where=robot.source)
    effects = dict.fromkeys(change.effect for model in competing.models for change in model.changes)
    every = catalogue(dict.fromkeys((*effects, *model_values())))
    unsimulated = without_collisions(robot, [robot.home()[None]])
    free = robot.without_contacts(unsimulated)
    return predictive_simulation_of(
        open_loop_simulator(free, every, [free], engine=config.engine), competing, robot, unsimulated
    )


def _clock(competing: CompetingModels, config: ProposeConfig) -> np.ndarray:
    """Times (rows,) of the commands, s: at the recordings' rate, within bounds."""
    rate = round(float(np.clip(competing.rate, _SLOWEST_ROWS, _FASTEST_ROWS)), 2)
    return np.arange(round(config.duration * rate) + 1) / rate


def _population(simulation: PredictiveSimulation, time: np.ndarray, config: ProposeConfig) -> int:
    """Motions in a generation: fewer for robots that are slow to simulate. Half of them are new in each."""
    each = simulation.lanes * max(len(time), (time[-1] - time[0]) / simulation.timestep)
    return int(np.clip(2.0 * _WORK / (each * config.generations), _FEWEST, config.population))


def _score(simulation: PredictiveSimulation, limits: Limits, time: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    def score(genomes: np.ndarray) -> np.ndarray:
        commands = [decode_commands(limits, time, genome) for genome in genomes]
        return np.array([_cost(predicted, simulation) for predicted in simulation.predict(time, commands, limits)])

    return score


def _cost(predicted: PredictedReadings, simulation: PredictiveSimulation, allowed: float = 0.0) -> float:
    """Cost, lower is better: negative within limits, positive beyond them, infinite if a simulation diverged."""
    if not np.isfinite(predicted.separation).all():
        return float("inf")
    if predicted.excess > allowed:
        return predicted.excess
    return -separation_score(predicted.separation, simulation.probabilities)


def _note(cost: float) -> str:
    if cost > 0.0:
        return "nothing within limits yet"
    return f"separation of {np.sqrt(max(cost**2 - 1.0, 0.0)):.3g} deviations"
