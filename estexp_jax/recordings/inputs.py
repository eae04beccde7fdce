"""The recordings that a command line names: a manifest, or a model and its logs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import final

from estexp_jax.errors import InputError
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import HEALTHY, Recording
from estexp_jax.recordings import read_manifest, read_recording
from estexp_jax.recordings.bind import bind_columns
from estexp_jax.recordings.checks.inspect import CLOCK_KINDS, judge
from estexp_jax.recordings.columns import Source, parse_map
from estexp_jax.recordings.frames import Frame, Log, frame_table
from estexp_jax.recordings.readers.read import is_log_folder
from estexp_jax.recordings.settings import apply_settings


@final
@dataclass(frozen=True, eq=False)
class Inputs:
    """What was read.

    Attributes:
        model: path of the MJCF.
        robot: it, compiled.
        recordings: in the order given, test recordings last; at least one.
    """

    model: Path
    robot: Robot
    recordings: tuple[Recording, ...]


def is_manifest(files: Sequence[Log | Robot]) -> bool:
    """Whether the files named begin with a manifest."""
    return bool(files) and isinstance(files[0], str) and Path(files[0]).suffix.lower() == ".toml"


def read_inputs(
    files: Sequence[Log | Robot],
    *,
    test: Sequence[Log] = (),
    healthy: Sequence[Log] = (),
    maps: Sequence[str] = (),
    mend: bool = False,
    root: str | Path | None = None,
) -> Inputs:
    """Read what a command line names, or a caller from Python gives.

    Args:
        files: a `recordings.toml` alone, or an MJCF or a robot, and logs.
        test: logs with the role `test`.
        healthy: logs of the same robot when it was well.
        maps: `ours=theirs`, for logs with other column names.
        mend: judge rather than refuse logs whose clock stands still or runs backwards.
        root: the folder that the model's files have to be under; None: see `Robot.from_xml`.

    Raises:
        InputError: nothing to read, a folder, a manifest together with other things, or a file that cannot be read.
    """
    folders = [(k, Path(file)) for k, file in enumerate(files) if isinstance(file, str) and Path(file).is_dir()]
    folder = next((path for k, path in folders if k == 0 or not is_log_folder(path)), None)
    if folder is not None:
        manifest = folder / "recordings.toml"
        right = f"the manifest in it, {manifest}" if manifest.is_file() else "a manifest, or a model and its logs"
        raise InputError("is a folder", where=str(folder), right=right)
    if is_manifest(files):
        manifest = str(files[0])
        if len(files) > 1 or test or healthy or maps:
            right = "it names logs, roles and columns itself; or give an MJCF and logs instead"
            raise InputError("a manifest stands alone", where=manifest, right=right)
        read = read_manifest(manifest, mend=mend, root=root)
        return _inputs(read.model, read.robot, read.recordings, mend)
    if len(files) + len(test) < 2 or not files:
        raise InputError("no recordings given", right="a recordings.toml, or an MJCF model and at least one log")
    model, *logs = files
    mapping = parse_maps(maps)
    robot = model if isinstance(model, Robot) else Robot.from_xml(str(model), root)
    roles = [(log, "train") for log in logs if not isinstance(log, Robot)] + [(log, "test") for log in test]
    roles += [(log, HEALTHY) for log in healthy]
    recordings = tuple(_recording(robot, log, role, mapping, mend) for log, role in roles)
    return _inputs(Path(robot.source), robot, recordings, mend)


def _recording(robot: Robot, log: Log, role: str, mapping: Mapping[str, Source], mend: bool) -> Recording:
    if isinstance(log, Frame):
        return bind_columns(robot, frame_table(log), role=role, mapping=mapping, mend=mend)
    return read_recording(robot, log, role=role, mapping=mapping, mend=mend)


def _inputs(model: Path, robot: Robot, recordings: Sequence[Recording], judged_later: bool) -> Inputs:
    """What was read; where nobody judges it later, with remarks on clocks that do not agree."""
    return Inputs(model, robot, tuple(r if judged_later else _with_clock_remarks(robot, r) for r in recordings))


def _with_clock_remarks(robot: Robot, recording: Recording) -> Recording:
    judged = judge(apply_settings(robot, recording.settings, where=recording.name), recording, replayed=False)
    faults = tuple(f"{each['name']}: {each['sentence']}" for each in judged["faults"] if each["kind"] in CLOCK_KINDS)
    return replace(recording, notes=(*recording.notes, *faults), clock_faults=faults)


def parse_maps(maps: Sequence[str]) -> dict[str, Source]:
    """Our column names to their sources, from `ours=theirs`.

    Raises:
        InputError: not of that form, or one of ours given twice.
    """
    mapping: dict[str, Source] = {}
    for text in maps:
        ours, source = parse_map(text)
        if ours in mapping:
            raise InputError(f"'{ours}' is mapped twice", where="--map", right="each of our columns once")
        mapping[ours] = source
    return mapping
