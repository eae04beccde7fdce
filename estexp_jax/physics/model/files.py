"""The files of a model, MJCF or URDF: found under the model's root, or refused before anything opens them.

A model's root is the folder that it came in, as `model_root` finds it, or that the user names. A way out of it, by
`..`, an absolute path or a link, is the user's error: a model from somebody else reads nothing but what came with it.

Of what MuJoCo opens, included files and attached models are found in the text, all others in the description that it
makes of the text.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

import mujoco

from estexp_jax.errors import InputError, abbreviated
from estexp_jax.physics.model.root import checked_root, model_root, package_folder
from estexp_jax.physics.model.xml_text import Element, xml_elements

_MOST_XML, _MOST_BYTES, _MOST_FILES = 16 * 2**20, 256 * 2**20, 1000
_MOST_PIXELS = 2**26
_OPENED = {"include": "file", "model": "file", "flexcomp": "file"}
"""Elements whose file MuJoCo opens while it reads."""
_SCHEMES = ("package://", "model://")


def read_description(path: Path, root: Path | None = None) -> mujoco.MjSpec:
    """Read a model whose files are all under its root.

    Args:
        path: of an MJCF or a URDF.
        root: the folder that its files have to be under; None: that of `model_root`.

    Returns:
        Its description, not compiled; files that it refers to are given by absolute paths.

    Raises:
        InputError: the model, or a file that it refers to, is missing, leads out of the model's root, or is too large;
            or the root is no folder above the model.
        ValueError: MuJoCo cannot read the text.
    """
    files = _Files(path, model_root(path) if root is None else checked_root(path, root), package_folder(path))
    models = files.read(path)
    spec = mujoco.MjSpec.from_file(str(path))
    for place, owner in _assets(spec):
        for field, file in _references(owner):
            _refer(owner, field, files.asset(file, place, owner.compiler, spec.strippath, models))
    spec.strippath = False
    return spec


def _assets(spec: mujoco.MjSpec) -> Iterator[tuple[str, Any]]:
    """Elements of a description that refer to files, with their place."""
    for kind, some in (
        ("mesh", spec.meshes),
        ("hfield", spec.hfields),
        ("skin", spec.skins),
        ("texture", spec.textures),
    ):
        for index, owner in enumerate(some):
            yield f"{kind} '{owner.name or index}'", owner


def _references(owner: Any) -> list[tuple[int | None, str]]:
    """The files of an asset: None for its one file, 0 to 5 for the sides of a cube."""
    found: list[tuple[int | None, str]] = [(None, owner.file)] if owner.file else []
    return found + [(side, file) for side, file in enumerate(getattr(owner, "cubefiles", ())) if file]


def _refer(owner: Any, side: int | None, file: Path) -> None:
    if side is None:
        owner.file = str(file)
    else:
        owner.cubefiles[side] = str(file)


@final
@dataclass(eq=False)
class _Files:
    """The files of one model.

    Attributes:
        model: its file.
        root: the folder that all have to be under, resolved.
        package: the ROS package around it, or else its own folder, resolved.
    """

    model: Path
    root: Path
    package: Path

    def __post_init__(self) -> None:
        self._visited: set[Path] = set()

    def read(self, path: Path, within: tuple[Path, ...] = (), *, attached: bool = False) -> tuple[Path, ...]:
        """Look over a model's text and all that it includes or attaches; gives the folders of these models.

        Args:
            path: the file.
            within: the files that led here.
            attached: whether one of them was attached, not included: MuJoCo itself refuses rings of includes only.
        """
        folder = path.absolute().parent
        self._visited.add(path.resolve())
        if len(self._visited) > _MOST_FILES:
            raise InputError(f"refers to more than {_MOST_FILES} files", where=str(self.model))
        folders, text = [folder], _text(path)
        for element in xml_elements(text, str(path)):
            for inner in self._opened(element, path, folder):
                if element.tag == "flexcomp":
                    continue
                below, link = (*within, path.resolve()), attached or element.tag == "model"
                if link and inner.resolve() in below:
                    raise InputError(f"attaches {inner.name}, which it is a part of", where=f"{path}, <{element.tag}>")
                if inner.resolve() not in self._visited:
                    folders += self.read(inner, below, attached=link)
        return tuple(dict.fromkeys(folders))

    def _opened(self, element: Element, path: Path, folder: Path) -> Iterator[Path]:
        """The files that MuJoCo may take an element to mean: those beside the model, and beside what includes it."""
        file = element.attributes.get(_OPENED.get(element.tag, ""), "")
        if not file:
            return
        place = f"{path}, <{element.tag}>"
        for base in dict.fromkeys((self.model.absolute().parent, folder)):
            for found in dict.fromkeys(
                (base / file, Path(os.path.normpath(base / file)))
            ):  # links before `..`, or after
                if is_file(self._inside(found, file, place)):
                    _sized(found, file, place, _MOST_XML if element.tag != "flexcomp" else _MOST_BYTES)
                    yield found

    def asset(self, file: str, what: str, compiler: Any, stripped: bool, models: Sequence[Path]) -> Path:
        """The file of an asset, of any of the models that were read."""
        place = f"{self.model}, {what}"
        subfolder = compiler.texturedir if what.startswith("texture") else compiler.meshdir
        named = Path(file).name if stripped else file
        tried = list(self._candidates(named, subfolder, models))
        within = [candidate for candidate in tried if self._is_within(candidate)]
        inside = [self._inside(candidate, file, place) for candidate in within or tried]
        found = list(dict.fromkeys(candidate for candidate in inside if is_file(candidate)))
        if not found:
            if outside := next((candidate for candidate in tried if candidate not in within), None):
                self._inside(outside, file, place)
            right = f"put it under {self.root}, or give --root DIR; a ROS package is known by its package.xml"
            raise InputError(f"there is no file {abbreviated(file)} under the model's root", where=place, right=right)
        if len(found) > 1 and len({candidate.read_bytes() for candidate in found}) > 1:
            raise InputError(
                f"{abbreviated(file)} may be any of {len(found)} files", where=place, right="name them apart"
            )
        if found[0].suffix.lower() == ".dae":
            raise InputError(
                f"{abbreviated(file)} is a Collada file", where=place, right="convert it to OBJ, STL or MSH"
            )
        _sized(found[0], file, place, _MOST_BYTES)
        _pixels(found[0], file, place)
        return found[0]

    def _candidates(self, file: str, subfolder: str, models: Sequence[Path]) -> Iterator[Path]:
        scheme = next((s for s in _SCHEMES if file.startswith(s)), None)
        if scheme is None:
            yield from (folder / subfolder / file for folder in models)
            return
        package, _, rest = file.removeprefix(scheme).partition("/")
        for base in dict.fromkeys((self.package, self.package.parent, self.root)):
            if base.is_relative_to(self.root):
                yield from (base / rest, base / package / rest)

    def _is_within(self, candidate: Path) -> bool:
        try:
            return candidate.resolve().is_relative_to(self.root)
        except (OSError, ValueError, RuntimeError):
            return False

    def _inside(self, candidate: Path, file: str, place: str) -> Path:
        """A path with all links followed, if it is under the root."""
        try:
            resolved = candidate.resolve()
        except (OSError, ValueError, RuntimeError):  # a loop of links, a NUL, a name that no file can have
            raise InputError(f"{abbreviated(file)} is no path", where=place) from None
        if not resolved.is_relative_to(self.root):
            right = f"a model reads only what is under its root, {self.root}; copy the file there, or give --root DIR"
            raise InputError(f"{abbreviated(file)} leads out of the model's root", where=place, right=right)
        return resolved


def _text(path: Path) -> str:
    _sized(path, path.name, str(path), _MOST_XML)
    try:
        raw = path.read_bytes()
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", where=str(path)) from None
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        return raw.decode("latin-1")


def is_file(path: Path) -> bool:
    """Whether there is such a file; a path that no file can have is that of none."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def _sized(path: Path, file: str, place: str, most: int) -> None:
    size = path.stat().st_size
    if size > most:
        raise InputError(f"{abbreviated(file)} is {size:,} bytes long", where=place, right=f"at most {most:,}")


def _pixels(path: Path, file: str, place: str) -> None:
    """Refuse pictures that unpack to anything."""
    with path.open("rb") as stream:
        head = stream.read(24)
    if head[:8] == b"\x89PNG\r\n\x1a\n" and len(head) == 24:
        width, height = struct.unpack(">II", head[16:])
        if width * height > _MOST_PIXELS:
            said = f"{abbreviated(file)} claims {width:,} x {height:,} pixels"
            raise InputError(said, where=place, right=f"at most {_MOST_PIXELS:,} in all")
