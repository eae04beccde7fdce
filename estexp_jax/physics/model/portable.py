"""A model that can be moved: its MJCF text, and the files that belong beside it."""

from __future__ import annotations

import re
from html import unescape
from pathlib import Path
from xml.sax.saxutils import escape

import mujoco

ASSETS = "assets"
"""Folder beside the text that the files belong into."""
_FILE = re.compile(r'( file\w*=")([^"]*)"')
_FOLDERS = re.compile(r' (?:mesh|texture)dir="[^"]*"')


def portable(spec: mujoco.MjSpec) -> tuple[str, dict[str, Path]]:
    """MJCF text of a compiled description that finds its files (meshes, height fields, textures) in `ASSETS` beside it.

    Returns:
        The text, and the name in `ASSETS` of each file to be copied. Files that are not given by absolute paths, as
        those of a `Robot.from_xml` are, stay as they are.
    """
    names: dict[str, Path] = {}

    def moved(found: re.Match[str]) -> str:
        path = Path(unescape(found[2]))
        if not path.is_absolute():
            return found[0]
        name = next((name for name, other in names.items() if other == path), None) or free_file(path, names)
        names[name] = path
        return f'{found[1]}{ASSETS}/{escape(name, {chr(34): "&quot;"})}"'

    text = precise_xml(spec)
    rewritten = _FILE.sub(moved, text)
    return (_FOLDERS.sub("", rewritten) if names else text), names


def precise_xml(spec: mujoco.MjSpec) -> str:
    """A description as text with all digits, or with six before MuJoCo 4, which has no more."""
    if hasattr(spec.compiler, "savecompiled"):
        spec.compiler.savecompiled = False  # else values have six digits
    return spec.to_xml()


def free_file(path: Path, names: dict[str, Path]) -> str:
    """A file name that no other file has: `link.stl`, `link_2.stl`, ..."""
    name, count = path.name, 1
    while name in names:
        count += 1
        name = f"{path.stem}_{count}{path.suffix}"
    return name
