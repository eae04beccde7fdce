"""Proposing what to record next: the motion within limits on which the rivals of an explanation disagree most."""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import final

import mujoco
import numpy as np

from estexp_jax.discovery.contest import Contest
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
from estexp_jax.physics.model.clearance import without_collisions
from estexp_jax.physics.model.robot import Robot
from estexp_jax.search.driver import evolve
from estexp_jax.search.genetic import Genetic, Population

_SLOWEST_ROWS, _FASTEST_ROWS = 20.0, 200.0
"""Bounds of the rate of proposed commands, Hz."""
_FINALISTS, _RANDOM = 4, 8
"""So many of the best commands, and of random ones, are simulated at the fine step in the end."""
_WORK, _FEWEST = 12_000_000, 12
"""Robot steps that a search may take, and fewest motions in a generation, however long it takes."""
PLAIN = 3.0
"""Deviations from which on rivals are plainly apart: neither noise nor ordinary errors of the model blur that."""
SLACK = 0.02
"""So far beyond a limit, as of `Limits.excess`, a motion may turn out to go at the fine step."""
_STRENGTHS = (0.9, 0.5, 0.25, 0.12, 0.06, 0.03)
"""Strengths at which random motions are tried, as shares of the reach of commands."""
_MUTATION = 0.15
"""Genomes are short, and few are tried."""


@final
@dataclass(frozen=True)
class ProposeConfig:
    """How to look for a separating motion.

    Attributes:
        duration: of the motion, s.
        margin: share of each range of command, joint and force that may be used.
        speed: how many times as fast as in the recordings joints may move.
        seed: of the search.
        engine: auto, lanes or mjx.
        population: most motions in a generation.
        generations: of the search.

    Raises:
        InputError: a number makes no sense.
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
    """A motion to record, and what each rival predicts of it.

    Attributes:
        robot: the nominal one.
        contest: the rivals.
        config: how it was looked for.
        time: (rows,) s.
        commands: (rows, nu).
        shown: what the rivals do under these commands.
        usual: (rivals, rivals) median separation by random motions of the same length within the same limits.
        robot_steps: robot steps simulated.
        engine: which one, and why.
    """

    robot: Robot
    contest: Contest
    config: ProposeConfig
    time: np.ndarray
    commands: np.ndarray
    shown: PredictedReadings
    usual: np.ndarray
    robot_steps: int
    engine: tuple[str, str]


def search_experiment(
    robot: Robot, contest: Contest, finer: int, config: ProposeConfig
) -> Generator[Progress, None, ProposedExperiment]:
    """Search for the motion that separates rivals most.

    Motions are evolved at the model's own step. The best ones, and random ones to compare with, are then simulated at
    the fine step that explanations were fitted at. The robot begins at home, at rest; what rivals claim acts all along,
    also where it began part-way through the recordings. Parts that are apart at home are to stay so. Errors of the
    start are left out: it will be measured, and soon forgotten by robots that are held by servos.

    Args:
        robot: the nominal one.
        contest: at least two rivals.
        finer: part of the model's step to judge at.
        config: how to search.

    Yields:
        Progress.

    Raises:
        InputError: there are no rivals or no actuators, or no engine simulates the robot.
    """
    yield Progress("preparing", 0, 1, f"{len(contest.rivals)} rivals")
    rehearsal = _rehearsal(robot, contest, config)
    speeds = config.speed * np.where((contest.speeds > 0.0) & ~_unlimited(robot, contest), contest.speeds, np.inf)
    limits, time = limits_of(robot, config.margin, contest.commands, speeds), _clock(contest, config)
    population = _population(rehearsal, time, config)
    genetic = Genetic(GENES * robot.model.nu, population, config.seed, mutation=_MUTATION)
    final: Population | None = None
    for final in evolve(genetic, _score(rehearsal, limits, time), config.generations):
        yield Progress("searching motions", final.generation, config.generations, _note(float(final.scores[0])))
    yield Progress("judging the best", 0, 1)
    finalists = [] if final is None else list(dict.fromkeys(tuple(g) for g in final.genomes.tolist()))[:_FINALISTS]
    tried = [decode_commands(limits, time, np.array(g)) for g in finalists]
    usual = _random(rehearsal, limits, time, config.seed)
    shown = rehearsal.finer(finer).shown(time, tried + usual, limits)
    best = min(range(len(shown)), key=lambda i: _cost(shown[i], rehearsal, SLACK))
    typical = np.median([np.nan_to_num(s.apart) for s in shown[len(tried) :]], axis=0)
    engine, reason = rehearsal.replayer.choice
    steps, choice = rehearsal.counted[0], (engine, reason)
    return ProposedExperiment(robot, contest, config, time, (tried + usual)[best], shown[best], typical, steps, choice)


def _unlimited(robot: Robot, contest: Contest) -> np.ndarray:
    """Degrees of freedom (nv,) for which how fast they moved is no limit.

    Their motors were told the same all along, or they are those of a floating base, which moves as the legs make it.
    """
    model, held = robot.model, np.zeros(robot.model.nv, dtype=bool)
    for joint in np.flatnonzero(model.jnt_type == int(mujoco.mjtJoint.mjJNT_FREE)).tolist():
        held[model.jnt_dofadr[joint] : model.jnt_dofadr[joint] + 6] = True
    joints = (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT))
    for a, (low, high) in enumerate(contest.commands):
        if low == high and int(model.actuator_trntype[a]) in joints:
            held[model.jnt_dofadr[model.actuator_trnid[a, 0]]] = True
    return held


def _random(rehearsal: PredictiveSimulation, limits: Limits, time: np.ndarray, seed: int) -> list[np.ndarray]:
    """Commands (rows, nu) of random motions, each as strong as the limits allow, or as weak as it is tried."""
    found = []
    for k in range(_RANDOM):
        tried = [random_motion(limits, time, strength, seed + k) for strength in _STRENGTHS]
        within = [c for c, s in zip(tried, rehearsal.shown(time, tried, limits), strict=True) if s.excess <= 0.0]
        found.append((within or tried[-1:])[0])
    return found


def _rehearsal(robot: Robot, contest: Contest, config: ProposeConfig) -> PredictiveSimulation:
    if len(contest.rivals) < 2:
        raise InputError("there are no rivals to tell apart", where=robot.source)
    if robot.model.nu == 0:
        raise InputError("the robot has no actuators, so no motion can be proposed", where=robot.source)
    effects = dict.fromkeys(change.effect for rival in contest.rivals for change in rival.changes)
    every = catalogue(dict.fromkeys((*effects, *model_values())))
    apart = without_collisions(robot, [robot.home()[None]])
    free = robot.without_contacts(apart)
    return predictive_simulation_of(
        open_loop_simulator(free, every, [free], engine=config.engine), contest, robot, apart
    )


def _clock(contest: Contest, config: ProposeConfig) -> np.ndarray:
    """Rows (rows,) of the commands, s: at the recordings' rate, within bounds."""
    rate = round(float(np.clip(contest.rate, _SLOWEST_ROWS, _FASTEST_ROWS)), 2)
    return np.arange(round(config.duration * rate) + 1) / rate


def _population(rehearsal: PredictiveSimulation, time: np.ndarray, config: ProposeConfig) -> int:
    """Motions in a generation, half of which are new each time: fewer of robots that take long to simulate."""
    each = rehearsal.lanes * max(len(time), (time[-1] - time[0]) / rehearsal.timestep)
    return int(np.clip(2.0 * _WORK / (each * config.generations), _FEWEST, config.population))


def _score(rehearsal: PredictiveSimulation, limits: Limits, time: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    def score(genomes: np.ndarray) -> np.ndarray:
        commands = [decode_commands(limits, time, genome) for genome in genomes]
        return np.array([_cost(shown, rehearsal) for shown in rehearsal.shown(time, commands, limits)])

    return score


def _cost(shown: PredictedReadings, rehearsal: PredictiveSimulation, allowed: float = 0.0) -> float:
    """Lower is better: negative within limits, positive where more than allowed beyond, infinite for what blew up."""
    if not np.isfinite(shown.apart).all():
        return float("inf")
    return shown.excess if shown.excess > allowed else -separation_score(shown.apart, rehearsal.probabilities)


def _note(cost: float) -> str:
    if cost > 0.0:
        return "nothing within limits yet"
    return f"rivals {np.sqrt(max(cost**2 - 1.0, 0.0)):.3g} deviations apart"
