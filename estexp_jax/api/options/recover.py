"""Options of `recover`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal, final

import tyro

from estexp_jax.api.options.ranges import SEEDS, CheckedOptions, Range


@final
@dataclass(frozen=True)
class RecoverOptions(CheckedOptions):
    """Recover a robot from damage: it walks, gets damaged, finds out what broke from its sensors alone, walks again.

    One run of the estimation-exploration algorithm of Bongard and Lipson (2004), on the quadruped or a robot of yours.

    Example:
        estexp recover --situation 3 --seed 0 --quick --out out/leg_lost
        estexp recover my_robot.xml --damage "motor_weakness@knee_f loss=0.5" --out out/weak_knee
        estexp recover my_robot.xml --hardware out/exchange --out out/my_robot
    """

    model: Annotated[tyro.conf.Positional[Path | None], tyro.conf.arg(metavar="[MODEL.xml]")] = None
    """An MJCF with position or motor actuators, and touch or jointpos sensors. Default: the quadruped."""
    root: Annotated[Path | None, tyro.conf.arg(metavar="DIR")] = None
    """The folder under which the model finds its files. Default: the repository or package around it, else three
    folders up."""
    out: Annotated[Path, tyro.conf.arg(metavar="DIR")] = Path("out/recover")
    """Where to write report.html, run.json, history.parquet and traces.npz."""
    situation: Annotated[int | None, Range(1, 13)] = None
    """What happens to the robot: 1 to 13 as in the paper's Table 1, at places drawn with the seed. Default: 3."""
    damage: Annotated[tyro.conf.UseAppendAction[tuple[str, ...]], tyro.conf.arg(metavar="EFFECT@NAME VALUE")] = ()
    """What happens instead of a situation, such as "motor_weakness@knee_f loss=0.5"; may be repeated."""
    seed: Annotated[int, SEEDS] = 0
    """Of all random numbers; same seed, same run."""
    quick: bool = False
    """A small setting: minutes on two cores."""
    paper: bool = False
    """Diagnose with the paper's genetic algorithm instead of the set search."""
    metric: Literal["rolling-mean", "distance"] = "rolling-mean"
    """What a diagnosis is judged by: the first sensor readings, or the distance."""
    robot: Literal["same", "foreign"] | None = None
    """The robot in the world: the same simulator with the damage in it, or another engine with errors of its own.
    Default: same."""
    hardware: Annotated[Path | None, tyro.conf.arg(metavar="DIR")] = None
    """The robot in the world is a damaged one of yours. For each trial controller_<i>.npz is written there, and
    commands_<i>.csv to play open loop or to compare with; its recording trial_<i>.csv is waited for: best written
    elsewhere and renamed into place."""
    healthy: bool = False
    """With --hardware: the robot is not damaged yet; healthy_0.csv, its recording under controller_0.npz, is waited for
    before trial_0.csv, and diagnoses are better for it."""
    passes: Annotated[int | None, Range(1, 1000)] = None
    """Estimations, and hardware trials after them; exploration runs once more. Default: 4."""
    population: Annotated[int | None, Range(4, 100_000)] = None
    """Genomes in a generation. Default: 200."""
    generations: Annotated[int | None, Range(1, 100_000)] = None
    """Generations of a phase. Default: 40."""
    steps: Annotated[int | None, Range(1, 100_000)] = None
    """Control steps of a trial. Default: 1000."""
    control_step: Annotated[float | None, Range(1e-5, 10.0)] = None
    """Time between two commands, s. Default: 0.01."""
    settle_steps: Annotated[int | None, Range(1, 100_000)] = None
    """Control steps with all motors at home before every trial. Default: 50."""
    axis: Literal["x", "-x", "y", "-y"] = "x"
    """Direction in which distance counts."""
    header: Annotated[int | None, Range(1, 100_000)] = None
    """Control steps of a trial that the rolling mean compares. Default: 20."""
    window: Annotated[int | None, Range(2, 100_000)] = None
    """Width of the rolling mean, control steps; even. Default: 10."""
    mutation: Annotated[float | None, Range(0.0, 1.0)] = None
    """Chance of each value of a copied genome to be drawn anew. Default: 0.01."""
    gain: Annotated[float | None, Range(0.0, 1000.0, open=True)] = None
    """Of the neurons' tanh. Default: 3."""
    catalogue: Literal["full", "paper"] = "full"
    """What the set search chooses from: the paper's six modifications, or more of what may break."""
    model_error: Annotated[float | None, Range(0.0, 0.3)] = None
    """Relative error expected in the simulator; 0: it is exact. Default: 0 for --robot same, else 0.03."""
    ensemble: Annotated[int | None, Range(1, 100)] = None
    """Simulators, as far off as --model-error and with noisy sensors, on which each controller is tried. Default: 1 if
    that is 0 and with --paper, else 4."""
    next_trial: Literal["farthest", "informative"] = "farthest"
    """Which controller the robot tries next: the one that comes farthest, or, of those that come nearly as far, the one
    on which explanations that are not excluded yet disagree most."""
    engine: Literal["auto", "lanes", "c", "mjx"] = "auto"
    """What simulates: lanes, the fast one, where it can simulate the robot; else mjx. Not c: it has no controllers."""
    pictures: bool = True
    """Show how the robot walks, where a GL is: film.jpg, film.mp4 (extra `video`), both in the report, too."""
    force: bool = False
    """Replace the results in DIR."""
    resume: bool = False
    """Go on with the interrupted run in DIR."""
