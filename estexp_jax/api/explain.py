"""`explain`, from Python and as the command: find the physics that a simulator lacks."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from time import perf_counter
from typing import Any, Literal, NamedTuple

from estexp_jax.api.options.explain import ExplainOptions
from estexp_jax.api.options.keywords import front_door
from estexp_jax.discovery.baseline import explain_change
from estexp_jax.discovery.diagnosis import Case, Diagnosis, ExplainConfig, explaining
from estexp_jax.discovery.explain import explain as explain_case
from estexp_jax.discovery.fitting import Progress as Step
from estexp_jax.errors import InputError, known
from estexp_jax.physics.engines.choice import left_out_by
from estexp_jax.physics.model.given import ModelLike, path_or_robot
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.recordings.frames import Logs, logs_of
from estexp_jax.recordings.inputs import Inputs, read_inputs
from estexp_jax.recordings.roles import without_healthy
from estexp_jax.recordings.settings import apply_settings
from estexp_jax.report.explain.files import write_explanation
from estexp_jax.report.explain.result import ExplainResult
from estexp_jax.runs import (
    ProgressDisplay,
    RunFolder,
    count_compilations,
    enable_compilation_cache,
    forget_programs,
    load_checkpoint,
    open_run,
    save_checkpoint,
    versions,
)


@front_door(ExplainOptions)
def explain(
    model: ModelLike,
    recordings: Logs = (),
    *,
    test: Logs = (),
    healthy: Logs = (),
    map: Iterable[str] = (),  # noqa: A002 (the command's word)
    root: str | Path | None = None,
    window: float | str = 2.0,
    most: int = 5,
    effects: Sequence[str] | None = (),
    engine: Literal["auto", "lanes", "c", "mjx"] = "auto",
    for_: Literal["mujoco", "mjx"] = "mujoco",
    seed: int = 0,
    progress: Callable[[Step], None] | None = None,
) -> ExplainResult:
    """Find the physics that a simulator lacks, from recordings of the robot.

    Args:
        model: the nominal robot: a path, MJCF text, an MjSpec, an MjModel or a Robot; or a `recordings.toml` that names
            model, recordings and columns.
        recordings: a log to learn from or several: paths, a glob, data frames, dictionaries of arrays.
        test: logs to prove it on; as recordings. Without any, the last recording is kept back; of a single one, its
            last 30 %.
        healthy: logs of the same robot when it was well; as recordings. The simulator is first fitted to these, then
            what changed since is explained, and that alone.
        map: `ours=theirs` for logs with other column names.
        root: folder under which the model finds its files; None: the repository or package around it, else three up.
        window: length of the windows compared, s; infinite or `full` for whole recordings.
        most: largest number of effects in an explanation.
        effects: names of the effects to consider; empty or None: all that it can, and those that were registered.
        engine: auto, lanes, c or mjx.
        for_: what simulates the corrected model later: for mjx, it keeps to the elements that MJX has.
        seed: of the resampling behind probabilities and intervals.
        progress: called with each step of the work.

    Raises:
        InputError: a keyword, a value or a file is wrong, or the model cannot be simulated.
    """
    files, tests = [path_or_robot(model), *logs_of(recordings)], logs_of(test, "test_frame")
    well = logs_of(healthy, "healthy_frame")
    inputs = read_inputs(files, test=tests, healthy=well, maps=list(map), root=root)
    config = explain_config_of(window, most, effects, seed, engine, for_)
    return run_explanation(inputs, config, {}, progress or (lambda _: None))


class WrittenExplanation(NamedTuple):
    """What `explain_to_folder` found, and where it is."""

    result: ExplainResult
    report: Path
    no_pictures: str  #: why the report has none though they were wanted; empty: it has, or they were not


def explain_to_folder(options: ExplainOptions) -> WrittenExplanation:
    """Explain as the command does: with progress, into a folder, able to go on after an interruption.

    Raises:
        InputError: an input or option is wrong, or the folder cannot be used.
    """
    config = explain_config_of(
        options.window, options.most, options.effects, options.seed, options.engine, options.for_
    )
    tests = [path for group in options.test for path in group]
    healthy = [path for group in options.healthy for path in group]
    inputs = read_inputs(options.files, test=tests, healthy=healthy, maps=options.map, root=options.root)
    window = "full" if options.window == float("inf") else options.window
    files = {"files": options.files, "test": tests, "map": options.map, "window": window}
    files |= {"healthy": healthy} if healthy else {}
    chosen = {"most": config.most, "effects": config.effects, "seed": config.seed, "engine": config.engine}
    meant = {"for": options.for_} if config.for_mjx else {}  # runs begun before there was such an option go on
    marker = {"command": "explain", "config": {**files, **chosen, **meant}}
    folder = open_run(options.out, force=options.force, resume=options.resume, marker=marker)
    result = _explain_with_progress(inputs, config, folder)
    report, missing = write_explanation(folder, result.diagnosis, result.findings, pictures=options.pictures)
    return WrittenExplanation(result, report, missing)


def explain_config_of(
    window: float | str,
    most: int,
    effects: Sequence[str] | None,
    seed: int,
    engine: str = "auto",
    for_: str = "mujoco",
) -> ExplainConfig:
    """The configuration of these choices.

    Raises:
        InputError: there is an unknown effect among them.
    """
    every = explaining()
    chosen = tuple(effects) if effects else every
    for name in chosen:
        if name not in every:
            raise InputError(f"'{name}' is not an effect to explain with", where="--effects", right=known(every))
    length = float("inf") if window == "full" else float(window)
    return ExplainConfig(window=length, most=most, effects=chosen, seed=seed, engine=engine, for_mjx=for_ == "mjx")


def cases_of(inputs: Inputs) -> tuple[Case, Case | None]:
    """Recordings with their roles, and the nominal robot under each one's settings: as it is, and when it was well.

    Raises:
        InputError: no recording is left to learn from, or names clash.
    """
    now, healthy = without_healthy(inputs.recordings)
    return _case(inputs.robot, now), _case(inputs.robot, healthy) if healthy else None


def _case(robot: Robot, recordings: tuple[Recording, ...]) -> Case:
    robots = tuple(apply_settings(robot, r.settings, where=r.name) for r in recordings)
    return Case(robot, recordings, robots)


def run_explanation(
    inputs: Inputs, config: ExplainConfig, memory: dict[str, Any], report: Callable[[Step], None]
) -> ExplainResult:
    """Explain, timing it.

    Args:
        inputs: what was read.
        config: how to explain.
        memory: state of an interrupted explanation; filled as this one goes on.
        report: called after each step, when `memory` is up to date.
    """
    enable_compilation_cache()
    forget_programs()
    begin = perf_counter()
    with count_compilations() as compiled:
        now, healthy = cases_of(inputs)
        steps = explain_case(now, config, memory)
        if healthy is not None:
            steps = explain_change(healthy, now, config, memory)
        while True:
            try:
                report(next(steps))
            except StopIteration as end:
                diagnosis: Diagnosis = end.value
                break
    cost = {**diagnosis.findings["cost"], "wall_s": perf_counter() - begin, "compile_s": compiled.seconds}
    return ExplainResult(diagnosis, {**diagnosis.findings, "cost": cost, "versions": versions()})


def _explain_with_progress(inputs: Inputs, config: ExplainConfig, folder: RunFolder) -> ExplainResult:
    """Explain, keeping after each step what an interruption would lose."""
    kept = folder.file("checkpoint.npz")
    memory: dict[str, Any] = (load_checkpoint(kept) or {}) if folder.resumed else {}
    if not isinstance(memory, dict):
        raise InputError("the checkpoint is damaged", where=str(kept), right="begin anew with --force")
    running = ""
    with ProgressDisplay() as progress:
        progress.say(f"Explaining {len(inputs.recordings)} recordings of {inputs.model.name}")
        for part in left_out_by(config.engine, inputs.robot):
            progress.say(f"Simulated without {part}")
        progress.stage("replaying the nominal simulator")

        def report(step: Step) -> None:
            nonlocal running
            save_checkpoint(kept, memory)
            if step.stage != running:
                running = step.stage
                progress.stage(step.stage, total=step.total)
            else:
                progress.advance(note=step.note)

        return run_explanation(inputs, config, memory, report)
