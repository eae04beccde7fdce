"""The folder that a model came in, under which it may read files: collections keep scenes and meshes beside models."""

from __future__ import annotations

from pathlib import Path

from estexp_jax.errors import InputError

_MARKERS = (".git", "pyproject.toml", "package.xml")
"""Files and folders that the folder of a repository or of a package holds."""
_LEVELS = 3
"""Folders above a model's own that it may read from where nothing marks where it came in."""


def model_root(path: Path) -> Path:
    """The nearest folder above a model that a repository or package begins in; else three folders up.

    A repository is known by its `.git`, a project by its `pyproject.toml`, a ROS package by its `package.xml`, and a
    Python package by the `__init__.py` that the folder above it lacks. The user's home folder and what is above it are
    never three folders up.

    Args:
        path: of the model.

    Returns:
        The folder, resolved.
    """
    own = path.absolute().parent.resolve()
    for folder in (own, *own.parents):
        if any((folder / marker).exists() for marker in _MARKERS) or _is_outermost_package(folder):
            return folder
    above = [folder for folder in own.parents[:_LEVELS] if not _is_shared(folder)]
    return above[-1] if above else own


def checked_root(path: Path, root: Path) -> Path:
    """A root that the user names, resolved.

    Raises:
        InputError: it is no folder, or the model is not under it.
    """
    if not root.is_dir():
        raise InputError("is no folder", where=f"--root {root}", right="a folder above the model")
    found = root.resolve()
    if not path.absolute().parent.resolve().is_relative_to(found):
        raise InputError(f"the model {path} is not under it", where=f"--root {root}", right="a folder above the model")
    return found


def package_folder(path: Path) -> Path:
    """The ROS package around a model, resolved; its own folder where there is none."""
    own = path.absolute().parent.resolve()
    return next((folder for folder in (own, *own.parents) if (folder / "package.xml").is_file()), own)


def _is_outermost_package(folder: Path) -> bool:
    return (folder / "__init__.py").is_file() and not (folder.parent / "__init__.py").is_file()


def _is_shared(folder: Path) -> bool:
    """Whether a folder holds more than one user's things, or all of a user's."""
    return folder == Path(folder.anchor) or Path.home().is_relative_to(folder)
