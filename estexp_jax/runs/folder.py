"""Run folders: what `--out`, `--force` and `--resume` mean."""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import Any, final

from estexp_jax.errors import InputError, unwritable
from estexp_jax.runs.checkpoint import previous_of
from estexp_jax.runs.files import drafts_of, is_draft, json_plain, write_json
from estexp_jax.runs.lock import LOCK, FolderLock, lock_folder

MARKER = ".estexp-run.json"
"""The file by which a run folder is known: what was run, and which files it wrote."""

_FORMAT = "estexp.run/1"


@final
@dataclass(frozen=True, eq=False)
class RunFolder:
    """A folder that holds one run's results. Made by `open_run`.

    Every file of the run is asked for with `file` or `directory`: what was asked for is what `--force` may remove.

    Attributes:
        path: the folder.
        marker: what is run: its command and configuration, as plain JSON.
        resumed: whether an earlier run of the same marker is gone on with.
        kept: what `--force` found in the folder and left there, as the run had not written it.

    As long as this object lives, no other process gets the folder.
    """

    path: Path
    marker: Mapping[str, Any]
    resumed: bool = False
    kept: tuple[str, ...] = ()
    _written: dict[str, None] = field(default_factory=dict, repr=False)
    _hold: FolderLock | None = field(default=None, repr=False)

    def file(self, name: str) -> Path:
        """Where the run's file `name` (`run.json`, `predictions/a.csv`) is to be written; its folder is made.

        Raises:
            InputError: the folder cannot be written.
        """
        path = self._noted(name)
        _make(path.parent)
        return path

    def directory(self, name: str) -> Path:
        """A folder of the run, made if need be; all in it counts as written by the run.

        Raises:
            InputError: the folder cannot be written.
        """
        path = self._noted(name)
        _make(path)
        return path

    def _noted(self, name: str) -> Path:
        if not _inside(name) or name in (MARKER, LOCK):
            raise ValueError(f"'{name}' is no place inside a run folder")
        if name not in self._written:
            self._written[name] = None
            self._save()
        return self.path / name

    def _save(self) -> None:
        document = {"format": _FORMAT, "marker": self.marker, "written": list(self._written)}
        write_json(self.path / MARKER, document)


def open_run(
    out: str | Path,
    *,
    force: bool = False,
    resume: bool = False,
    marker: Mapping[str, Any] | None = None,
    patience: float = 0.0,
) -> RunFolder:
    """Take a folder for a run's results; it and its parents are made if need be.

    Args:
        out: the folder. New, empty, or the folder of an earlier run.
        force: remove what the earlier run wrote, and begin anew. Files that it did not write stay.
        resume: go on with the earlier run. Where there is none, a new one begins.
        marker: what decides the results, such as `{"command": "recover", "config": options}`; leave out what may
            change from one attempt to the next (`force`, `resume`, a number of workers).
        patience: how long to wait where another process is at work in the folder, s.

    Raises:
        InputError: the folder holds results and neither `force` nor `resume` is given, or both are; it holds things and
            is no run folder; the run to resume had another marker (names the field); another process is at work in it;
            or it cannot be written.
    """
    path, wanted = Path(out), json_plain(marker or {}, "marker")
    if force and resume:
        raise InputError("--force and --resume together", right="--force begins anew, --resume goes on: give one")
    if path.exists() and not path.is_dir():
        raise InputError("is a file", where=str(path), right="a folder for the results")
    _earlier(path)  # nothing is written in a foreign folder, not even a lock
    _make(path)
    held = lock_folder(path, patience)
    earlier = _earlier(path)
    if earlier is None:
        _remove_drafts(path, [])
        return _begun(RunFolder(path, wanted, _hold=held))
    if resume:
        _check_same(wanted, earlier["marker"], path)
        _remove_drafts(path, earlier["written"])
        return RunFolder(path, wanted, resumed=True, _written=dict.fromkeys(earlier["written"]), _hold=held)
    if not force:
        right = "--force removes them and begins anew, --resume goes on with an interrupted run; or give another folder"
        raise InputError("the folder holds results of an earlier run", where=str(path), right=right)
    _remove_written(path, earlier["written"])
    kept = tuple(sorted(item.name for item in path.iterdir() if item.name not in (MARKER, LOCK)))
    return _begun(RunFolder(path, wanted, kept=kept, _hold=held))


def _begun(folder: RunFolder) -> RunFolder:
    folder._save()
    return folder


def _earlier(path: Path) -> dict[str, Any] | None:
    """The marker file of the run in a folder; None where there is no folder, or nothing in it."""
    try:
        if not path.exists() or all(map(_is_beginning, path.iterdir())):
            return None
        # A link to a device is no file, and reading one might never end.
        document = json.loads((path / MARKER).read_text(encoding="utf-8")) if (path / MARKER).is_file() else None
    except (FileNotFoundError, ValueError, RecursionError):
        document = None
    except OSError as error:
        raise unwritable(path, error) from None
    if not _is_ours(document):
        right = f"no file of it is touched, not even with --force or --resume; {_elsewhere(path)}"
        raise InputError("the folder is not empty and was not made by estexp", where=str(path), right=right)
    return document


def _is_beginning(item: Path) -> bool:
    """Whether a run leaves this that was killed before its marker was there."""
    return item.name == LOCK or is_draft(item.name, MARKER)


def _is_ours(document: Any) -> bool:
    if not isinstance(document, dict) or document.get("format") != _FORMAT or "marker" not in document:
        return False
    written = document.get("written")
    return isinstance(written, list) and all(isinstance(name, str) and _inside(name) for name in written)


def _elsewhere(path: Path) -> str:
    return f"give another folder, such as {path / 'run'}"


def _inside(name: str) -> bool:
    """Whether a name is a place below the folder: relative, never up, and one that a file can have."""
    parts = PurePosixPath(name).parts
    return bool(parts) and not PurePosixPath(name).is_absolute() and ".." not in parts and "\0" not in name


def _remove_written(path: Path, written: list[str]) -> None:
    """Remove a run's files, what writing them may have left behind, and folders that are empty then."""
    try:
        for name in written:
            target = path / name
            if not target.parent.resolve().is_relative_to(path.resolve()):
                continue  # below a link that somebody put there
            if target.is_dir() and not target.is_symlink():
                shutil.rmtree(target)
            for file in (target, *drafts_of(target), previous_of(target)):
                file.unlink(missing_ok=True)
            _remove_empty(target.parent, path)
    except OSError as error:
        raise InputError(f"cannot be emptied: {error.strerror}", where=str(error.filename or path)) from None


def _remove_drafts(path: Path, written: list[str]) -> None:
    """Remove what a kill in the middle of a write has left; nobody else is at work in the folder."""
    for name in (MARKER, *written):
        for draft in drafts_of(path / name):
            with suppress(OSError):
                draft.unlink()


def _remove_empty(folder: Path, top: Path) -> None:
    while folder != top and folder.is_dir() and not any(folder.iterdir()):
        folder.rmdir()
        folder = folder.parent


def _check_same(wanted: Any, earlier: Any, path: Path) -> None:
    ours, theirs = _leaves(wanted), _leaves(earlier)
    for name in [*theirs, *(name for name in ours if name not in theirs)]:
        now, then = (json.dumps(leaves[name]) if name in leaves else "absent" for leaves in (ours, theirs))
        if now != then:
            right = f"resume with {name} = {then}, begin anew with --force, or give another folder"
            raise InputError(f"the run to resume had {name} = {then}, not {now}", where=str(path), right=right)


def _leaves(value: Any, name: str = "") -> dict[str, Any]:
    """Names with dots to values: {"config": {"seed": 0}} gives {"config.seed": 0}."""
    if not isinstance(value, dict) or not value:
        return {name: value}
    prefix = f"{name}." if name else ""
    return {path: leaf for key, item in value.items() for path, leaf in _leaves(item, f"{prefix}{key}").items()}


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise unwritable(folder, error) from None
