"""`check`, from Python and as the command: read and judge recordings, before anything is fitted to them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from estexp_jax.api.options.check import CheckOptions
from estexp_jax.api.options.keywords import front_door
from estexp_jax.errors import InputError
from estexp_jax.physics.model.given import ModelLike, path_or_robot
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recordings.frames import Logs, logs_of
from estexp_jax.recordings.inputs import Inputs, is_manifest, read_inputs
from estexp_jax.recordings.templates.alternatives import better_mappings
from estexp_jax.recordings.templates.manifest import write_manifest
from estexp_jax.recordings.templates.model import write_first_model
from estexp_jax.report.check.result import CheckResult, check_inputs, write_check
from estexp_jax.runs import open_run


@front_door(CheckOptions)
def check(
    model: ModelLike,
    recordings: Logs = (),
    *,
    test: Logs = (),
    map: Iterable[str] = (),  # noqa: A002 (the command's word)
    root: str | Path | None = None,
) -> CheckResult:
    """Read and judge recordings: clock, units, sensors, saturation, lags, which joints move enough to tell what.

    Args:
        model: the nominal robot: a path, MJCF text, an MjSpec, an MjModel or a Robot; or a `recordings.toml` that names
            model, recordings and columns.
        recordings: a log or several: paths, a glob, data frames, dictionaries of arrays.
        test: logs that are kept for the test; as recordings.
        map: `ours=theirs` for logs with other column names.
        root: folder under which the model finds its files; None: the repository or package around it, else three up.

    Raises:
        InputError: a keyword is wrong, or a file cannot be read.
    """
    files, tests = [path_or_robot(model), *logs_of(recordings)], logs_of(test, "test_frame")
    return check_inputs(read_inputs(files, test=tests, maps=list(map), mend=True, root=root))


def check_to_folder(options: CheckOptions, say: Callable[[str], object], show: Callable[[CheckResult], object]) -> None:
    """Check as the command does: with `--init`, and into a folder where one is given.

    Args:
        options: of the command.
        say: called with sentences about what was written.
        show: called with what was found, before it is written.

    Raises:
        InputError: a file cannot be read, or the folder cannot be used.
    """
    if options.init and len(options.files) == 1 and not (is_manifest(options.files) or options.test):
        path = write_first_model(Robot.from_xml(options.files[0], options.root), options.out or Path())
        say(f"{path}: written; put the gains of your servos into it, they are guesses")
        return
    tests = [path for group in options.test for path in group]
    config = {"files": options.files, "test": tests, "map": options.map, "init": options.init}
    read = None if options.init else read_inputs
    inputs = read and read(options.files, test=tests, maps=options.map, mend=True, root=options.root)
    folder = None
    if options.out is not None:
        marker = {"command": "check", "config": config}
        folder = open_run(options.out, force=options.force, resume=options.resume, marker=marker)
    inputs = inputs or _begin_manifest(options, tests, say)
    if inputs is None:
        return
    result = check_inputs(inputs)
    show(result)
    if folder is not None:
        files = write_check(folder, result)
        say(f"Numbers: {files.json_file}\nFigure: {files.figure}")


def _begin_manifest(options: CheckOptions, tests: Sequence[str], say: Callable[[str], object]) -> Inputs | None:
    """Write a first manifest; what it names, if it can be read as it is."""
    path = (options.out or Path()) / "recordings.toml"
    write_manifest(path, options.files, tests, options.map, options.root)
    say(f"{path}: written; see that its guesses are right")
    try:
        inputs = read_inputs([str(path)], mend=True, root=options.root)
        for sentence in dict.fromkeys(found for r in inputs.recordings for found in better_mappings(inputs.robot, r)):
            say(f"In doubt: {sentence}")
        return inputs
    except InputError as error:
        say(f"It is still to be completed: {error}")
        return None
