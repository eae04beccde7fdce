"""Settings of one run of the estimation-exploration algorithm."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any, Literal, final

from estexp_jax.errors import InputError
from estexp_jax.physics.engines.choice import Engine

Metric = Literal["rolling-mean", "distance"]
DEFAULT_MODEL_ERROR = 0.03
"""Relative standard deviation expected of the parameters of a simulator of a real robot."""
DEFAULT_ENSEMBLE = 4
"""Perturbed simulators on which each controller for a real robot is tried."""
Catalogue = Literal["full", "paper"]
Axis = Literal["x", "-x", "y", "-y"]
NextTrial = Literal["farthest", "informative"]


@final
@dataclass(frozen=True)
class Settings:
    """Settings of a run. The defaults are the paper's but for the estimation: `paper` selects the paper's.

    Raises:
        InputError: a setting is out of its range, or two settings contradict each other.
    """

    situation: int | None = 3
    """The damage: row 1 to 13 of the paper's Table 1, at places drawn with the seed."""
    damage: tuple[str, ...] = ()
    """Damage instead of a situation, such as "motor_weakness@knee_f loss=0.5"; may be repeated."""
    seed: int = 0
    """Seed of all random numbers. The same seed gives the same run."""
    passes: int = 4
    """Estimations, and hardware trials after them; exploration runs once more."""
    population: int = 200
    """Genomes in a generation of the genetic algorithm."""
    generations: int = 40
    """Generations in a phase."""
    steps: int = 1000
    """Control steps of a trial."""
    control_step: float = 0.01
    """Time between two commands, s."""
    settle_steps: int = 50
    """Control steps with all motors at home before every trial, so that the robot rests on the ground."""
    metric: Metric = "rolling-mean"
    """Cost of a diagnosis: error of the first sensor readings (equation 2), or of the distance (equation 1)."""
    header: int = 20
    """h of equation 2: control steps of a trial that are compared."""
    window: int = 10
    """w of equation 3: width of the rolling mean, control steps; even."""
    mutation: float = 0.01
    """Probability that a value of a copied genome is drawn anew."""
    gain: float = 3.0
    """Gain of the neurons' tanh."""
    axis: Axis = "x"
    """World axis along which distance counts."""
    robot: Literal["same", "foreign"] = "same"
    """The robot in the world: the same simulator with the damage planted, or another engine with parameter errors."""
    paper: bool = False
    """Diagnose with the paper's genetic algorithm instead of the set search."""
    catalogue: Catalogue = "full"
    """Candidates of the set search: the paper's six modifications, or these and other failures."""
    model_error: float | None = None
    """Relative error expected of the simulator's masses, gains, damping and friction; 0 if it is exact. Default: 0 for
    the same robot, else 0.03."""
    ensemble: int | None = None
    """Perturbed simulators (by `model_error`, with noisy sensors) on which each controller is tried; their mean
    distance counts. After the search, 32 others rank the last generation. Default: 1, the nominal one, for an exact
    simulator and with `paper`; else 4."""
    next_trial: NextTrial = "farthest"
    """The controller that the robot tries next. Farthest: the one that goes farthest in the simulator, as in the paper.
    Informative: among those that go nearly as far, the one on which the remaining explanations disagree most."""
    engine: Engine = "auto"
    """The engine. Auto: lanes, which is faster, where it can simulate the robot; else mjx."""

    def __post_init__(self) -> None:
        _check(self.situation is None or 1 <= self.situation <= 13, "--situation", self.situation, "1 to 13")
        _check(self.passes >= 1, "--passes", self.passes, "at least 1")
        _check(self.population >= 4, "--population", self.population, "at least 4")
        _check(self.generations >= 1, "--generations", self.generations, "at least 1")
        even = self.window >= 2 and self.window % 2 == 0
        _check(even, "--window", self.window, "an even number of control steps")
        _check(self.header > self.window, "--header", self.header, f"more than the window of {self.window}")
        _check(self.steps > self.header, "--steps", self.steps, f"more than the header of {self.header}")
        _check(self.control_step > 0.0, "--control-step", self.control_step, "a positive time")
        _check(self.settle_steps >= 1, "--settle-steps", self.settle_steps, "at least 1")
        _check(self.settle_steps <= self.steps, "--settle-steps", self.settle_steps, f"at most the {self.steps} steps")
        _check(0.0 <= self.mutation <= 1.0, "--mutation", self.mutation, "0 to 1")
        error = self.model_error
        _check(error is None or 0.0 <= error <= 0.3, "--model-error", error, "0 to 0.3")
        _check(self.ensemble is None or self.ensemble >= 1, "--ensemble", self.ensemble, "at least 1")
        distinct = self.ensemble_size == 1 or self.relative_error > 0.0
        _check(distinct, "--ensemble", self.ensemble, "1, or --model-error above 0: without error all are equal")
        allowed = self.next_trial == "farthest" or not self.paper
        _check(allowed, "--next-trial", self.next_trial, "farthest, as the paper's search keeps one explanation only")
        _check(self.seed >= 0, "--seed", self.seed, "0 or more")

    @property
    def samples(self) -> int:
        """Control steps of a trial that the rolling mean compares: h + 1."""
        return self.header + 1

    @property
    def relative_error(self) -> float:
        """Relative error expected of the simulator's parameters; 0 for an exact simulator."""
        return (0.0 if self.robot == "same" else DEFAULT_MODEL_ERROR) if self.model_error is None else self.model_error

    @property
    def ensemble_size(self) -> int:
        """Number of simulators on which each controller is tried."""
        if self.ensemble is not None:
            return self.ensemble
        return 1 if self.paper or self.relative_error == 0.0 else DEFAULT_ENSEMBLE

    def to_json(self) -> dict[str, Any]:
        """The settings as in `run.json`."""
        return asdict(self)


def quick_settings(settings: Settings) -> Settings:
    """The settings of `--quick`: a run takes minutes on two cores and still finds the damage."""
    return replace(settings, population=64, generations=10, steps=300)


def _check(holds: bool, where: str, value: object, right: str) -> None:
    if not holds:
        raise InputError(f"{value} is not possible", where=where, right=right)
