"""`estexp check`: read and judge recordings, before anything is fitted to them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from estexp_jax.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console

    from estexp_jax.api.inputs import Inputs


@dataclass(frozen=True)
class Options:
    """Read and judge recordings: clock, units, sensors, saturation, lags, which joints move enough to tell what.

    Nothing is simulated or fitted. Wherever the files could be read, this succeeds, whatever it finds.

    Example:
        estexp check recordings.toml --out out/check
        estexp check nominal.xml a.csv b.csv --map ctrl.servo=goal_position --init
        estexp check robot.urdf --init
    """

    files: Annotated[tyro.conf.Positional[tuple[str, ...]], tyro.conf.arg(metavar="FILE [FILE ...]")]
    """A recordings.toml; or an MJCF or URDF model and the logs of its robot; or, with --init, a URDF alone."""
    test: Annotated[
        tyro.conf.UseAppendAction[tuple[tuple[str, ...], ...]], tyro.conf.arg(metavar="FILE [FILE ...]")
    ] = ()
    """Logs that are kept for the test."""
    map: Annotated[tyro.conf.UseAppendAction[tuple[str, ...]], tyro.conf.arg(metavar="OURS=THEIRS")] = ()
    """A column of the logs that has another name than ours."""
    out: Annotated[Path | None, tyro.conf.arg(metavar="DIR")] = None
    """Where to write check.json and check.png."""
    init: bool = False
    """Write a first recordings.toml for the model and the logs, to be completed by hand; into DIR, or here. For a model
    alone: a first MJCF with servos and angle sensors at all joints that have none."""
    force: bool = False
    """Replace the results in DIR."""
    resume: bool = False
    """Go on with an interrupted check; short as it is, it is done again."""


def run(options: Options) -> int:
    """Check, print, and write what was asked for.

    Raises:
        InputError: a file cannot be read, or DIR cannot be used.
    """
    from estexp_jax.api.inputs import is_manifest, read_inputs
    from estexp_jax.runs import open_run

    if options.init and len(options.files) == 1 and not (is_manifest(options.files) or options.test):
        return _begin_model(options)
    tests = [path for group in options.test for path in group]
    config = {"files": options.files, "test": tests, "map": options.map, "init": options.init}
    inputs = None if options.init else read_inputs(options.files, test=tests, maps=options.map, mend=True)
    folder = None
    if options.out is not None:
        marker = {"command": "check", "config": config}
        folder = open_run(options.out, force=options.force, resume=options.resume, marker=marker)
    if inputs is None:
        inputs = _begin_manifest(options, tests)
    if inputs is None:
        return 0
    judged = _judge(inputs)
    _print(judged)
    if folder is not None:
        _write(folder, inputs, judged)
    return 0


def _begin_model(options: Options) -> int:
    """Write a first MJCF."""
    from estexp_jax.api.first_model import write_first_model
    from estexp_jax.physics.model.robot import Robot

    robot = Robot.from_xml(options.files[0])
    path = write_first_model(robot, options.out or Path())
    print(f"{path}: written; put the gains of your servos into it, they are guesses")
    return 0


def _begin_manifest(options: Options, tests: Sequence[str]) -> Inputs | None:
    """Write a first manifest; what it names, if it can be read as it is."""
    from estexp_jax.api.inputs import read_inputs
    from estexp_jax.cli.check_init import write_manifest

    path = (options.out or Path()) / "recordings.toml"
    write_manifest(path, options.files, tests, options.map)
    print(f"{path}: written; see that its guesses are right")
    try:
        return read_inputs([str(path)], mend=True)
    except InputError as error:
        print(f"It is still to be completed: {error}")
        return None


def _judge(inputs: Inputs) -> list[dict[str, Any]]:
    from estexp_jax.recordings.checks.inspect import judge
    from estexp_jax.recordings.settings import apply_settings

    return [judge(apply_settings(inputs.robot, r.settings, where=r.name), r) for r in inputs.recordings]


def _write(folder: Any, inputs: Inputs, judged: list[dict[str, Any]]) -> None:
    from estexp_jax.cli.check_figure import draw_check
    from estexp_jax.recordings.checks.excitation import missing
    from estexp_jax.runs import versions, write_json

    numbers, figure = folder.file("check.json"), folder.file("check.png")
    advice = list(missing(judged))
    write_json(numbers, {"model": inputs.model, "recordings": judged, "advice": advice, "versions": versions()})
    draw_check(inputs.robot, inputs.recordings, figure)
    print(f"Numbers: {numbers}\nFigure: {figure}")


def _print(judged: list[dict[str, Any]]) -> None:
    from rich.console import Console

    from estexp_jax.recordings.checks.excitation import missing

    console = Console(highlight=False)
    _print_table(console, "Recordings", ("file", "role", "rows", "s", "Hz", "jitter, ms", "gaps"), _recordings(judged))
    header = ("joint", "told by", "largest span", "moves in", "can tell apart")
    _print_table(console, "Joints", header, _joints(judged))
    _print_table(console, "Commands", ("actuator", "low", "high", "saturated", "motor on"), _commands(judged))
    for remark, files in _remarks(judged).items():
        where = "all recordings" if len(files) == len(judged) > 1 else ", ".join(files)
        console.print(f"{where}: {remark}", markup=False, soft_wrap=True)
    advice = list(missing(judged))
    for sentence in advice:
        console.print(f"to record: {sentence}", markup=False, soft_wrap=True)
    if not advice and not any(one["faults"] for one in judged):
        console.print("Nothing looks wrong, and the motions can tell the usual suspects apart.")


def _print_table(console: Console, title: str, header: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    from rich.table import Table
    from rich.text import Text

    table = Table(*header, title=title, title_justify="left")
    for row in rows:
        table.add_row(*(Text(cell, overflow="fold") for cell in row))
    console.print(table)


def _remarks(judged: list[dict[str, Any]]) -> dict[str, list[str]]:
    """What there is to say, each with the files that it is said of."""
    remarks: dict[str, list[str]] = {}
    for one in judged:
        for remark in [*one["notes"], *one["suspicions"]]:
            remarks.setdefault(remark, []).append(one["file"])
    return remarks


def _recordings(judged: list[dict[str, Any]]) -> list[tuple[str, ...]]:
    rows = []
    for one in judged:
        clock = one["clock"]
        times = (f"{one['duration_s']:.4g}", f"{clock['hz']:.4g}", f"{1e3 * clock['jitter_s']:.3g}")
        gaps = f"{clock['gaps']} (longest {clock['longest_s']:.3g} s)" if clock["gaps"] else "none"
        rows.append((one["file"], one["role"], str(one["rows"]), *times, gaps))
    return rows


def _joints(judged: list[dict[str, Any]]) -> list[tuple[str, ...]]:
    from estexp_jax.recordings.checks.excitation import SUSPECTS

    rows = []
    for name in judged[0]["joints"]:
        found = [one["joints"][name] for one in judged]
        columns = dict.fromkeys(column for joint in found for column in joint["columns"])
        span = max((joint["span"] for joint in found if joint["span"] is not None), default=None)
        moves = sum(joint["excited"] is True for joint in found)
        told = f"{moves} of {len(found)}" if columns else "unknown"
        able = [s.replace("_", " ") for s in SUSPECTS if any(joint["tells"].get(s) for joint in found)]
        motion = "-" if span is None else f"{span:.4g}", told, ", ".join(able) or "nothing yet"
        rows.append((name, ", ".join(columns) or "nothing", *motion))
    return rows


def _commands(judged: list[dict[str, Any]]) -> list[tuple[str, ...]]:
    return [(name, *_command([one["commands"][name] for one in judged])) for name in judged[0]["commands"]]


def _command(found: Sequence[Mapping[str, Any]]) -> tuple[str, ...]:
    low, high = min(command["low"] for command in found), max(command["high"] for command in found)
    saturated = max((command["saturated"] for command in found if command["saturated"] is not None), default=None)
    worst = "no limit" if saturated is None else f"up to {saturated:.1%}"
    return f"{low:.4g}", f"{high:.4g}", worst, f"{min(command['enabled'] for command in found):.0%} at least"
