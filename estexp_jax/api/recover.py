"""`recover`, from Python and as the command: walk, get damaged, diagnose from the sensors, walk again."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

from estexp_jax.api.options.keywords import front_door
from estexp_jax.api.options.recover import RecoverOptions
from estexp_jax.errors import InputError
from estexp_jax.hardware.exchange import HardwareTarget, check_exchange_folder, lock_exchange_folder
from estexp_jax.package_data import model_path
from estexp_jax.physics.model.given import ModelLike, robot_of
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.config import Settings, quick_settings
from estexp_jax.recovery.cycle import Job, job_of, run_cycle
from estexp_jax.recovery.state import RunState
from estexp_jax.recovery.target import Target
from estexp_jax.report.recover.files import write_recovery
from estexp_jax.report.recover.progress import RecoverProgress
from estexp_jax.report.recover.result import RecoverRun
from estexp_jax.runs import (
    ProgressDisplay,
    RunFolder,
    enable_compilation_cache,
    load_checkpoint,
    open_run,
    save_checkpoint,
)

_CHECKPOINT = "checkpoint.npz"
_SMALLER = ("passes", "population", "generations", "steps", "control_step", "settle_steps")
_NUMBERS = (*_SMALLER, "header", "window", "mutation", "gain")
"""Options that have no default of their own: `--quick` changes some."""


@front_door(RecoverOptions)
def recover(
    model: ModelLike,
    /,
    *,
    target: Target | None = None,
    situation: int | None = None,
    damage: Sequence[str] = (),
    seed: int = 0,
    quick: bool = False,
    paper: bool = False,
    metric: Literal["rolling-mean", "distance"] = "rolling-mean",
    robot: Literal["same", "foreign"] | None = None,
    passes: int | None = None,
    population: int | None = None,
    generations: int | None = None,
    steps: int | None = None,
    control_step: float | None = None,
    settle_steps: int | None = None,
    axis: Literal["x", "-x", "y", "-y"] = "x",
    header: int | None = None,
    window: int | None = None,
    mutation: float | None = None,
    gain: float | None = None,
    catalogue: Literal["full", "paper"] = "full",
    model_error: float | None = None,
    ensemble: int | None = None,
    next_trial: Literal["farthest", "informative"] = "farthest",
    engine: Literal["auto", "lanes", "c", "mjx"] = "auto",
) -> RecoverRun:
    """Recover a robot from damage: iterating over the result runs the algorithm pass by pass.

    Args:
        model: the nominal robot: a path, MJCF text, an MjSpec, an MjModel or a Robot.
        target: the damaged robot in the world, any callable: controller -> `ee.Trial`, or a dict with
            `readings` (steps, inputs) or `sensor.<name>` of each input; None: a simulated one.
        situation: 1 to 13 as in the paper's Table 1; None: 3, or none where `damage` is given.
        damage: what happens instead of a situation, such as "motor_weakness@knee_f loss=0.5".
        seed: of all random numbers.
        quick: start from the small settings of `--quick`.
        paper: diagnose with the paper's genetic algorithm instead of the set search.
        metric: what a diagnosis is judged by: the first sensor readings, or the distance.
        robot: the robot in the world: the same simulator (None, "same"), or another engine with errors of its own.
        passes: estimations, and hardware trials after them.
        population: genomes in a generation.
        generations: of a phase.
        steps: control steps of a trial.
        control_step: time between two commands, s.
        settle_steps: control steps with all motors at home before every trial.
        axis: direction in which distance counts.
        header: control steps of a trial that the rolling mean compares.
        window: width of the rolling mean, control steps; even.
        mutation: chance of each value of a copied genome to be drawn anew.
        gain: of the neurons' tanh.
        catalogue: what the set search chooses from.
        model_error: relative error expected in the simulator.
        ensemble: simulators on which each controller is tried.
        next_trial: which controller the robot tries next.
        engine: auto, lanes, c or mjx.

    Raises:
        InputError: a keyword, a value or the robot cannot be used.
    """
    enable_compilation_cache()
    options = RecoverOptions(
        situation=situation,
        damage=(damage,) if isinstance(damage, str) else tuple(damage),
        seed=seed,
        quick=quick,
        paper=paper,
        metric=metric,
        robot=robot,
        passes=passes,
        population=population,
        generations=generations,
        steps=steps,
        control_step=control_step,
        settle_steps=settle_steps,
        axis=axis,
        header=header,
        window=window,
        mutation=mutation,
        gain=gain,
        catalogue=catalogue,
        model_error=model_error,
        ensemble=ensemble,
        next_trial=next_trial,
        engine=engine,
    )
    return RecoverRun(job_of(robot_of(model), recover_settings_of(options), target))


def recover_settings_of(options: RecoverOptions) -> Settings:
    """The run's settings: the defaults or the quick ones, and over them what was given.

    Raises:
        InputError: they are not possible.
    """
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
    given_numbers = {name: getattr(options, name) for name in _NUMBERS if getattr(options, name) is not None}
    return replace(quick_settings(settings) if options.quick else settings, **given_numbers)


def _refuse_simulated(options: RecoverOptions) -> None:
    """See that nothing is asked for that only a simulated robot can do."""
    simulated = {"--situation": options.situation, "--damage": options.damage or None, "--robot": options.robot}
    for name, value in simulated.items():
        if value is not None:
            right = "what is wrong with a robot in the world is for it to show: leave it out"
            raise InputError(f"{name} and --hardware together", right=right)


def recover_to_folder(options: RecoverOptions) -> None:
    """Recover as the command does: with progress, into a folder, from where an earlier run was interrupted.

    Raises:
        InputError: the robot, the damage, the settings or a folder cannot be used.
    """
    settings, progress = recover_settings_of(options), ProgressDisplay()
    fresh = not options.resume or not any(options.out.glob(f"{_CHECKPOINT}*"))
    if options.hardware is not None:  # before --force removes anything
        check_exchange_folder(options.hardware, fresh=fresh, force=options.force)
    model = options.model or model_path("quadruped")
    robot = Robot.from_xml(model, options.root)
    job = _job_of_options(robot, settings, options, progress)
    for part in job.simulator.closed_loop.left_out:
        progress.say(f"Simulated without {part}")
    config = {"model": model.name, **job.settings.to_json(), "engine": job.simulator.closed_loop.choice.engine}
    if options.hardware is not None:
        config |= {"robot": "hardware", "healthy": options.healthy}
    marker = {"command": "recover", "config": config}
    folder = open_run(options.out, force=options.force, resume=options.resume, marker=marker)
    lock = options.hardware and lock_exchange_folder(options.hardware, fresh=fresh, force=options.force)
    enable_compilation_cache()
    with progress, lock or nullcontext():
        state = _run_with_progress(job, folder, RecoverProgress(progress, job), model.name)
        write_recovery(folder, job, state, config, progress, pictures=options.pictures)


def _job_of_options(robot: Robot, settings: Settings, options: RecoverOptions, progress: ProgressDisplay) -> Job:
    if options.hardware is None:
        return job_of(robot, settings)
    target = HardwareTarget(robot, settings, options.hardware, progress)
    healthy = HardwareTarget(robot, settings, options.hardware, progress, "healthy") if options.healthy else None
    return job_of(robot, settings, target, healthy=healthy)


def _run_with_progress(job: Job, folder: RunFolder, display: RecoverProgress, model: str) -> RunState:
    """Each state is saved before it is printed, so that what was printed is never lost."""
    saved = load_checkpoint(folder.file(_CHECKPOINT))
    state = RunState() if saved is None else _state_of(saved, folder.path)
    display.start(model, state)
    for reached in run_cycle(job, state):
        save_checkpoint(folder.file(_CHECKPOINT), reached.to_tree())
        display.update(state, reached)
        state = reached
    display.finish(state)
    return state


def _state_of(saved: Any, out: Path) -> RunState:
    try:
        return RunState.from_tree(saved)
    except (KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
        what = f"the checkpoint is damaged ({type(error).__name__}: {error})"
        raise InputError(what, where=str(out / _CHECKPOINT), right="begin anew with --force") from None
