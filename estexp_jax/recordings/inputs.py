"""The recordings that a command line names: a manifest, or a model and its logs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

from estexp_jax.errors import InputError
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.recordings import read_manifest, read_recording
from estexp_jax.recordings.columns import Source, parse_map


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


def is_manifest(files: Sequence[str]) -> bool:
    """Whether the files named begin with a manifest."""
    return bool(files) and Path(files[0]).suffix.lower() == ".toml"


def read_inputs(
    files: Sequence[str],
    *,
    test: Sequence[str] = (),
    maps: Sequence[str] = (),
    mend: bool = False,
    root: str | Path | None = None,
) -> Inputs:
    """Read what a command line names.

    Args:
        files: a `recordings.toml` alone, or an MJCF and logs.
        test: logs with the role `test`.
        maps: `ours=theirs`, for logs with other column names.
        mend: judge rather than refuse logs whose clock stands still or runs backwards.
        root: the folder that the model's files have to be under; None: see `Robot.from_xml`.

    Raises:
        InputError: nothing to read, a folder, a manifest together with other things, or a file that cannot be read.
    """
    folder = next((Path(file) for file in files if Path(file).is_dir()), None)
    if folder is not None:
        manifest = folder / "recordings.toml"
        right = f"the manifest in it, {manifest}" if manifest.is_file() else "a manifest, or a model and its logs"
        raise InputError("is a folder", where=str(folder), right=right)
    if is_manifest(files):
        if len(files) > 1 or test or maps:
            right = "it names logs, roles and columns itself; or give an MJCF and logs instead"
            raise InputError("a manifest stands alone", where=files[0], right=right)
        read = read_manifest(files[0], mend=mend, root=root)
        return Inputs(read.model, read.robot, read.recordings)
    if len(files) + len(test) < 2 or not files:
        raise InputError("no recordings given", right="a recordings.toml, or an MJCF model and at least one log")
    robot, mapping = Robot.from_xml(files[0], root), parse_maps(maps)
    roles = [(path, "train") for path in files[1:]] + [(path, "test") for path in test]
    recordings = tuple(read_recording(robot, path, role=role, mapping=mapping, mend=mend) for path, role in roles)
    return Inputs(Path(files[0]), robot, recordings)


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
