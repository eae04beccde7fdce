"""Run folders: the meaning of `--out`, `--force` and `--resume`."""

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
"""The file that identifies a run folder: what was run, and which files it wrote."""

_FORMAT = "estexp.run/1"


@final
@dataclass(frozen=True, eq=False)
class RunFolder:
    """A folder that holds one run's results, created by `open_run`.

    Every path of the run is requested with `file` or `directory`; `--force` removes only paths that were requested.

    Attributes:
        path: the folder.
        marker: command and configuration of the run, as plain JSON.
        resumed: whether this continues an earlier run with the same marker.
        kept: files that `--force` left in the folder, since the run had not written them.

    While this object exists, no other process can open the folder.
    """

    path: Path
    marker: Mapping[str, Any]
    resumed: bool = False
    kept: tuple[str, ...] = ()
    _written: dict[str, None] = field(default_factory=dict, repr=False)
    _lock: FolderLock | None = field(default=None, repr=False)

    def file(self, name: str) -> Path:
        """The path of the run's file `name` (`run.json`, `predictions/a.csv`); its folder is created.

        Raises:
            InputError: the folder cannot be written.
        """
        path = self._register(name)
        _make(path.parent)
        return path

    def directory(self, name: str) -> Path:
        """A folder of the run, created if needed; everything in it counts as written by the run.

        Raises:
            InputError: the folder cannot be written.
        """
        path = self._register(name)
        _make(path)
        return path

    def _register(self, name: str) -> Path:
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
    """Open a folder for a run's results; it and its parents are created if needed.

    Args:
        out: the folder. New, empty, or the folder of an earlier run.
        force: remove the files of the earlier run and start a new one. Other files stay.
        resume: continue the earlier run, or start a new one if there is none.
        marker: everything that determines the results, such as `{"command": "recover", "config": options}`; without
            options that may change between attempts (`force`, `resume`, the number of workers).
        patience: how long to wait if another process uses the folder, s.

    Raises:
        InputError: the folder holds results and neither or both of `force` and `resume` are given; it holds files and
            is not a run folder; the run to resume had another marker (names the field); another process uses it; or it
            cannot be written.
    """
    path, wanted = Path(out), json_plain(marker or {}, "marker")
    if force and resume:
        raise InputError("--force and --resume together", right="--force begins anew, --resume goes on: give one")
    if path.exists() and not path.is_dir():
        raise InputError("is a file", where=str(path), right="a folder for the results")
    _earlier(path)  # before the lock file, as nothing may be written in a folder that is not a run's
    _make(path)
    lock = lock_folder(path, patience)
    earlier = _earlier(path)
    if earlier is None:
        _remove_drafts(path, [])
        return _save_new(RunFolder(path, wanted, _lock=lock))
    if resume:
        _check_same(wanted, earlier["marker"], path)
        _remove_drafts(path, earlier["written"])
        return RunFolder(path, wanted, resumed=True, _written=dict.fromkeys(earlier["written"]), _lock=lock)
    if not force:
        right = "--force removes them and begins anew, --resume goes on with an interrupted run; or give another folder"
        raise InputError("the folder holds results of an earlier run", where=str(path), right=right)
    _remove_written(path, earlier["written"])
    kept = tuple(sorted(item.name for item in path.iterdir() if item.name not in (MARKER, LOCK)))
    return _save_new(RunFolder(path, wanted, kept=kept, _lock=lock))


def _save_new(folder: RunFolder) -> RunFolder:
    folder._save()
    return folder


def _earlier(path: Path) -> dict[str, Any] | None:
    """The marker of the run in a folder; None if the folder does not exist or is empty."""
    try:
        if not path.exists() or all(map(_is_beginning, path.iterdir())):
            return None
        # Reading a link to a device might never end, so it must be a file.
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
    """Whether a run that was killed before writing its marker leaves this file."""
    return item.name == LOCK or is_draft(item.name, MARKER)


def _is_ours(document: Any) -> bool:
    if not isinstance(document, dict) or document.get("format") != _FORMAT or "marker" not in document:
        return False
    written = document.get("written")
    return isinstance(written, list) and all(isinstance(name, str) and _inside(name) for name in written)


def _elsewhere(path: Path) -> str:
    return f"give another folder, such as {path / 'run'}"


def _inside(name: str) -> bool:
    """Whether a name is a valid path below the folder: relative and without `..`."""
    parts = PurePosixPath(name).parts
    return bool(parts) and not PurePosixPath(name).is_absolute() and ".." not in parts and "\0" not in name


def _remove_written(path: Path, written: list[str]) -> None:
    """Remove a run's files, their drafts, and folders that become empty."""
    try:
        for name in written:
            target = path / name
            if not target.parent.resolve().is_relative_to(path.resolve()):
                continue  # below a link that was placed there
            if target.is_dir() and not target.is_symlink():
                shutil.rmtree(target)
            for file in (target, *drafts_of(target), previous_of(target)):
                file.unlink(missing_ok=True)
            _remove_empty(target.parent, path)
    except OSError as error:
        raise InputError(f"cannot be emptied: {error.strerror}", where=str(error.filename or path)) from None


def _remove_drafts(path: Path, written: list[str]) -> None:
    """Remove the drafts of killed processes; the folder is locked, so no other process is writing."""
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
