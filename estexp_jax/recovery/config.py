"""What one run of the estimation-exploration algorithm is told."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any, Literal, final

from estexp_jax.errors import InputError
from estexp_jax.physics.engines.choice import Engine

Metric = Literal["rolling-mean", "distance"]
ROUGH = 0.03
"""Relative error expected in the parameters of a simulator of a real robot."""
ENSEMBLE = 4
"""Simulators on which a controller is tried that is to walk on a real robot."""
Catalogue = Literal["full", "paper"]
Axis = Literal["x", "-x", "y", "-y"]
NextTrial = Literal["farthest", "telling"]


@final
@dataclass(frozen=True)
class Settings:
    """Settings of a run; the defaults are the paper's, except for the estimation, which `paper` sets to the paper's."""

    situation: int | None = 3
    """What happens to the robot: 1 to 13 as in the paper's Table 1, at places drawn with the seed."""
    damage: tuple[str, ...] = ()
    """What happens instead of a situation, such as "motor_weakness@knee_f loss=0.5"; may be repeated."""
    seed: int = 0
    """Of all random numbers; same seed, same run."""
    passes: int = 4
    """Estimations, and hardware trials after them; exploration runs once more."""
    population: int = 200
    """Genomes in a generation of the genetic algorithm."""
    generations: int = 40
    """Generations of a phase."""
    steps: int = 1000
    """Control steps of a trial."""
    control_step: float = 0.01
    """Time between two commands, s."""
    settle_steps: int = 50
    """Control steps with all motors at home before every trial, so that the robot rests on the ground."""
    metric: Metric = "rolling-mean"
    """What a diagnosis is judged by: the first sensor readings (equation 2), or the distance (equation 1)."""
    header: int = 20
    """h of equation 2: how many control steps of a trial are compared."""
    window: int = 10
    """w of equation 3: width of the rolling mean, control steps; even."""
    mutation: float = 0.01
    """Chance of each value of a copied genome to be drawn anew."""
    gain: float = 3.0
    """Of the neurons' tanh."""
    axis: Axis = "x"
    """Direction in which distance counts."""
    robot: Literal["same", "foreign"] = "same"
    """The robot in the world: the same simulator with the damage in it, or another engine with errors of its own."""
    paper: bool = False
    """Diagnose with the paper's genetic algorithm instead of the set search."""
    catalogue: Catalogue = "full"
    """What the set search chooses from: the paper's six modifications, or more of what may break."""
    model_error: float | None = None
    """Relative error expected in the simulator's masses, gains, damping and friction; 0: it is exact. Default: 0 for
    the same robot, else 0.03."""
    ensemble: int | None = None
    """Simulators, as far off as `model_error` and with noisy sensors, on which each controller is tried; the mean
    distance counts. Of the last generation, and of what the robot tried, 32 others choose. Default: 1, which is the
    nominal one, for an exact simulator and with `paper`, else 4."""
    next_trial: NextTrial = "farthest"
    """The controller that the robot tries next: the one that comes farthest in the simulator, as in the paper; or, of
    those that come nearly as far, the one on which explanations that are not excluded yet disagree most."""
    engine: Engine = "auto"
    """What simulates: lanes, the fast one, where it can simulate the robot; else mjx."""

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
        rough = self.members == 1 or self.rough > 0.0
        _check(rough, "--ensemble", self.ensemble, "1, or --model-error above 0, else they are all alike")
        told = self.next_trial == "farthest" or not self.paper
        _check(told, "--next-trial", self.next_trial, "farthest, as the paper's search keeps no rivals")
        _check(self.seed >= 0, "--seed", self.seed, "0 or more")

    @property
    def samples(self) -> int:
        """Readings of a trial that the rolling mean compares: h + 1."""
        return self.header + 1

    @property
    def rough(self) -> float:
        """Relative error expected in the simulator's parameters."""
        return (0.0 if self.robot == "same" else ROUGH) if self.model_error is None else self.model_error

    @property
    def members(self) -> int:
        """Simulators on which each controller is tried."""
        if self.ensemble is not None:
            return self.ensemble
        return 1 if self.paper or self.rough == 0.0 else ENSEMBLE

    def to_json(self) -> dict[str, Any]:
        """As in `run.json`."""
        return asdict(self)


def quick_settings(settings: Settings) -> Settings:
    """The small setting of `--quick`: minutes on two cores, and still finds the damage and walks again."""
    return replace(settings, population=64, generations=10, steps=300)


def _check(holds: bool, where: str, value: object, right: str) -> None:
    if not holds:
        raise InputError(f"{value} is not possible", where=where, right=right)
