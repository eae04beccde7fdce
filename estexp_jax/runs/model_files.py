"""A model in a run folder, with the meshes and textures that belong beside it."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from pathlib import Path

from estexp_jax.errors import InputError
from estexp_jax.physics.model.portable import ASSETS
from estexp_jax.physics.model.source_model import ModelFiles
from estexp_jax.runs.files import write_text
from estexp_jax.runs.folder import RunFolder


def write_model(folder: RunFolder, name: str, model: tuple[str, Mapping[str, Path]]) -> None:
    """Write a model and the files that belong beside it, as `portable` gives them.

    Raises:
        InputError: one of the files is gone, or cannot be copied.
    """
    text, files = model
    _copy(folder, {f"{ASSETS}/{file}": source for file, source in files.items()})
    write_text(folder.file(name), text)


def write_model_files(folder: RunFolder, name: str, model: ModelFiles) -> None:
    """Write a model under a name, with the files that it includes and its meshes and textures where it looks for them.

    Raises:
        InputError: one of the files is gone, or cannot be copied.
    """
    _copy(folder, model.assets)
    for file, text in model.included.items():
        write_text(folder.file(file), text)
    write_text(folder.file(name), model.text)


def _copy(folder: RunFolder, files: Mapping[str, Path]) -> None:
    for file, source in files.items():
        try:
            shutil.copyfile(source, folder.file(file))
        except shutil.SameFileError:
            pass
        except OSError as error:
            raise InputError(f"cannot be copied: {error.strerror}", where=str(source)) from None
