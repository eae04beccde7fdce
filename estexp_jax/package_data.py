"""Files that come with the package: robots and schemas."""

from __future__ import annotations

from pathlib import Path

from estexp_jax.errors import InputError, known

_PACKAGE = Path(__file__).resolve().parent
# In a wheel the models lie inside the package; in a checkout, and so in an editable install, beside it.
_MODELS = (_PACKAGE / "models", _PACKAGE.parent / "models")
_SCHEMAS = (_PACKAGE / "schemas",)


def model_path(name: str) -> Path:
    """The MJCF file of a robot that comes with the package.

    Args:
        name: `quadruped`, or `quadruped.xml`.

    Raises:
        InputError: no such robot comes with it; lists those that do.
    """
    return _find(name, ".xml", _MODELS, "model")


def schema_path(name: str) -> Path:
    """The JSON Schema of a file that the package writes.

    Args:
        name: `findings`, or `findings.schema.json`.

    Raises:
        InputError: there is no such schema; lists those that exist.
    """
    return _find(name, ".schema.json", _SCHEMAS, "schema")


def _find(name: str, extension: str, folders: tuple[Path, ...], what: str) -> Path:
    file = name if name.endswith(extension) else f"{name}{extension}"
    choices = {path.name: path for folder in reversed(folders) for path in sorted(folder.glob(f"*{extension}"))}
    if file not in choices:
        right = known(path.removesuffix(extension) for path in choices)
        raise InputError(f"no {what} '{name}' comes with the package", right=right)
    return choices[file]
