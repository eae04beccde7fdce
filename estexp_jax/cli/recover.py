"""`estexp recover`: walk, get damaged, diagnose from the sensors, walk again."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from estexp_jax.errors import InputError

if TYPE_CHECKING:
    from estexp_jax.physics.model.robot import Robot
    from estexp_jax.recovery.config import Settings
    from estexp_jax.recovery.cycle import Job
    from estexp_jax.recovery.state import RunState
    from estexp_jax.runs import ProgressDisplay, RunFolder

_CHECKPOINT = "checkpoint.npz"


@dataclass(frozen=True)
class Options:
    """Recover a robot from damage: it walks, gets damaged, finds out what broke from its sensors alone, walks again.

    One run of the estimation-exploration algorithm of Bongard and Lipson (2004), on the quadruped or a robot of yours.

    Example:
        estexp recover --situation 3 --seed 0 --quick --out out/leg_lost
        estexp recover my_robot.xml --damage "motor_weakness@knee_f loss=0.5" --out out/weak_knee
        estexp recover my_robot.xml --hardware out/exchange --out out/my_robot
    """

    model: Annotated[tyro.conf.Positional[Path | None], tyro.conf.arg(metavar="[MODEL.xml]")] = None
    """An MJCF with position or motor actuators, and touch or jointpos sensors. Default: the quadruped."""
    out: Annotated[Path, tyro.conf.arg(metavar="DIR")] = Path("out/recover")
    """Where to write report.html, run.json, history.parquet and traces.npz."""
    situation: int | None = None
    """What happens to the robot: 1 to 13 as in the paper's Table 1, at places drawn with the seed. Default: 3."""
    damage: Annotated[tyro.conf.UseAppendAction[tuple[str, ...]], tyro.conf.arg(metavar="EFFECT@NAME VALUE")] = ()
    """What happens instead of a situation, such as "motor_weakness@knee_f loss=0.5"; may be repeated."""
    seed: int = 0
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
    passes: int | None = None
    """Estimations, and hardware trials after them; exploration runs once more. Default: 4."""
    population: int | None = None
    """Genomes in a generation. Default: 200."""
    generations: int | None = None
    """Generations of a phase. Default: 40."""
    steps: int | None = None
    """Control steps of a trial. Default: 1000."""
    control_step: float | None = None
    """Time between two commands, s. Default: 0.01."""
    settle_steps: int | None = None
    """Control steps with all motors at home before every trial. Default: 50."""
    axis: Literal["x", "-x", "y", "-y"] = "x"
    """Direction in which distance counts."""
    header: int | None = None
    """Control steps of a trial that the rolling mean compares. Default: 20."""
    window: int | None = None
    """Width of the rolling mean, control steps. Default: 10."""
    mutation: float | None = None
    """Chance of each value of a copied genome to be drawn anew. Default: 0.01."""
    gain: float | None = None
    """Of the neurons' tanh. Default: 3."""
    catalogue: Literal["full", "paper"] = "full"
    """What the set search chooses from: the paper's six modifications, or more of what may break."""
    model_error: float | None = None
    """Relative error expected in the simulator; 0: it is exact. Default: 0 for --robot same, else 0.03."""
    ensemble: int | None = None
    """Simulators, as far off as --model-error and with noisy sensors, on which each controller is tried. Default: 1 if
    that is 0 and with --paper, else 4."""
    next_trial: Literal["farthest", "informative"] = "farthest"
    """Which controller the robot tries next: the one that comes farthest, or, of those that come nearly as far, the one
    on which explanations that are not excluded yet disagree most."""
    engine: Literal["auto", "lanes", "mjx"] = "auto"
    """What simulates: lanes, the fast one, where it can simulate the robot; else mjx."""
    pictures: bool = True
    """Show how the robot walks, where a GL is: film.jpg, film.mp4 (extra `video`), both in the report, too."""
    force: bool = False
    """Replace the results in DIR."""
    resume: bool = False
    """Go on with the interrupted run in DIR."""


_SMALLER = ("passes", "population", "generations", "steps", "control_step", "settle_steps")
_NUMBERS = (*_SMALLER, "header", "window", "mutation", "gain")


def settings_of(options: Options) -> Settings:
    """The run's settings: the defaults or the quick ones, and over them what was given.

    Raises:
        InputError: they are not possible.
    """
    from estexp_jax.recovery.config import Settings, quick_settings

    if options.hardware is not None:
        _refuse_simulated(options)
    elif options.healthy:
        raise InputError("without --hardware", where="--healthy", right="a simulated robot is always tried before, too")
    if options.damage and options.situation is not None:
        raise InputError("--situation and --damage together", right="--damage takes the place of a situation: give one")
    given = bool(options.damage) or options.hardware is not None
    situation = None if given else 3 if options.situation is None else options.situation
    settings = Settings(
        situation=situation,
        damage=options.damage,
        seed=options.seed,
        metric=options.metric,
        robot=options.robot or "same",
        axis=options.axis,
        paper=options.paper,
        engine=options.engine,
        catalogue=options.catalogue,
        model_error=options.model_error,
        ensemble=options.ensemble,
        next_trial=options.next_trial,
    )
    numbers = {name: getattr(options, name) for name in _NUMBERS if getattr(options, name) is not None}
    return replace(quick_settings(settings) if options.quick else settings, **numbers)


def _refuse_simulated(options: Options) -> None:
    """See that nothing is asked for that only a simulated robot can do."""
    simulated = {"--situation": options.situation, "--damage": options.damage or None, "--robot": options.robot}
    for name, value in simulated.items():
        if value is not None:
            right = "what is wrong with a robot in the world is for it to show: leave it out"
            raise InputError(f"{name} and --hardware together", right=right)


def run(options: Options) -> int:
    """Run to the end, or from where an earlier run was interrupted.

    Raises:
        InputError: the robot, the damage, the settings or DIR cannot be used.
    """
    from estexp_jax.api.hardware import check_exchange_folder, lock_exchange_folder
    from estexp_jax.cli.recover_results import write_recover_results
    from estexp_jax.cli.recover_story import Story
    from estexp_jax.package_data import model_path
    from estexp_jax.physics.engines.mjx.capabilities import reduced_to_mjx
    from estexp_jax.physics.model.robot import Robot
    from estexp_jax.recovery.state import RunState
    from estexp_jax.runs import ProgressDisplay, enable_compilation_cache, load_checkpoint, open_run

    settings, progress = settings_of(options), ProgressDisplay()
    fresh = not options.resume or not any(options.out.glob(f"{_CHECKPOINT}*"))
    if options.hardware is not None:  # before --force removes anything
        check_exchange_folder(options.hardware, fresh=fresh, force=options.force)
    model = options.model or model_path("quadruped")
    robot = Robot.from_xml(model)
    for part in reduced_to_mjx(robot).left_out:
        progress.say(f"Simulated without {part}")
    job = _job(robot, settings, options, progress)
    config = {"model": model.name, **job.settings.to_json(), "engine": job.simulator.closed_loop.choice.engine}
    if options.hardware is not None:
        config |= {"robot": "hardware", "healthy": options.healthy}
    marker = {"command": "recover", "config": config}
    folder = open_run(options.out, force=options.force, resume=options.resume, marker=marker)
    held = options.hardware and lock_exchange_folder(options.hardware, fresh=fresh, force=options.force)
    enable_compilation_cache()
    saved = load_checkpoint(folder.file(_CHECKPOINT))
    state = RunState() if saved is None else _state(saved, options.out)
    with progress, held or nullcontext():
        story = Story(progress, job)
        story.begin(model.name, state)
        state = _run(job, state, folder, story)
        story.end(state)
        write_recover_results(folder, job, state, config, progress, pictures=options.pictures)
    return 0


def _job(robot: Robot, settings: Settings, options: Options, progress: ProgressDisplay) -> Job:
    from estexp_jax.api.hardware import HardwareTarget
    from estexp_jax.recovery.cycle import job_of

    if options.hardware is None:
        return job_of(robot, settings)
    target = HardwareTarget(robot, settings, options.hardware, progress)
    healthy = HardwareTarget(robot, settings, options.hardware, progress, "healthy") if options.healthy else None
    return job_of(robot, settings, target, healthy=healthy)


def _state(saved: Any, out: Path) -> RunState:
    from estexp_jax.recovery.state import RunState

    try:
        return RunState.from_tree(saved)
    except (KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
        told = f"the checkpoint is damaged ({type(error).__name__}: {error})"
        raise InputError(told, where=str(out / _CHECKPOINT), right="begin anew with --force") from None


def _run(job: Job, state: RunState, folder: RunFolder, story: Any) -> RunState:
    """Each state saved before it is told, so that what was told is never lost."""
    from estexp_jax.recovery.cycle import run_cycle as run_cycle
    from estexp_jax.runs import save_checkpoint

    for reached in run_cycle(job, state):
        save_checkpoint(folder.file(_CHECKPOINT), reached.to_tree())
        story.tell(state, reached)
        state = reached
    return state
