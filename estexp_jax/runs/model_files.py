"""A model in a run folder, with the meshes and textures that belong beside it."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from pathlib import Path

from estexp_jax.errors import InputError
from estexp_jax.physics.model.portable import ASSETS
from estexp_jax.runs.files import write_text
from estexp_jax.runs.folder import RunFolder


def write_model(folder: RunFolder, name: str, model: tuple[str, Mapping[str, Path]]) -> None:
    """Write a model and the files that belong beside it, as `portable` gives them.

    Raises:
        InputError: one of the files is gone, or cannot be copied.
    """
    text, files = model
    for file, source in files.items():
        try:
            shutil.copyfile(source, folder.file(f"{ASSETS}/{file}"))
        except shutil.SameFileError:
            pass
        except OSError as error:
            raise InputError(f"cannot be copied: {error.strerror}", where=str(source)) from None
    write_text(folder.file(name), text)
