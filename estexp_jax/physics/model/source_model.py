"""A changed model as its author wrote it: comments, includes, defaults and names stay, only what changed differs."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any, final
from xml.etree.ElementTree import Element

import mujoco
import numpy as np

from estexp_jax.physics.model.portable import ASSETS, free_file, precise_xml
from estexp_jax.physics.model.validation import mujoco_warnings_suppressed
from estexp_jax.physics.model.xml_edits import Spelling, edit_source
from estexp_jax.physics.model.xml_source import NotEditable, SourceElement, read_source

_FOLDERS = ("meshdir", "texturedir", "assetdir")
_SIDES = ("fileright", "fileleft", "fileup", "filedown", "filefront", "fileback")
_CLOSE = {"rtol": 1e-7, "atol": 1e-12}
"""Two texts of one model: degrees and radians differ in the last digits."""
_NAMES = ("name", "nname", "path", "npath", "nbuffer", "signature")


@final
@dataclass(frozen=True)
class ModelFiles:
    """A model and what belongs beside it, by paths relative to its folder.

    Attributes:
        text: of the model itself.
        included: texts of the files that it includes.
        assets: where its meshes and textures are to be copied from.
    """

    text: str
    included: Mapping[str, str]
    assets: Mapping[str, Path]


def changed_source(
    path: Path,
    before: mujoco.MjSpec,
    after: mujoco.MjSpec,
    *,
    taken: Collection[str] = (),
    spelled: Spelling | None = None,
) -> ModelFiles | None:
    """The files of a model in which a description was changed, as its author wrote them; None where that cannot be.

    What comes out is compiled, and compared number by number with what was wanted.

    Args:
        path: of the author's model, MJCF.
        before: its description, compiled.
        after: the changed one, compiled.
        taken: names that no included file may have.
        spelled: gives new elements as an author would write them, where the defaults let them be that.
    """
    wanted = after.compile()
    for frozen, written in product((True, False), (spelled or _as_it_is, _as_it_is)):
        try:
            found = _changed(path, before, after, frozen=frozen, taken=taken, spelled=written)
            if _is_model(found, wanted):
                return found
        except (NotEditable, OSError, ValueError, KeyError, RuntimeError, mujoco.FatalError):
            continue
    return None


def _changed(
    path: Path,
    before: mujoco.MjSpec,
    after: mujoco.MjSpec,
    *,
    frozen: bool,
    taken: Collection[str],
    spelled: Spelling,
) -> ModelFiles:
    folder = path.absolute().parent

    def included(file: str, includer: str) -> tuple[str, bytes]:
        for base in (Path(), Path(includer).parent):
            name = os.path.normpath(base / file)
            if (folder / name).is_file() and not name.startswith("..") and not os.path.isabs(name):
                if name in taken:
                    raise NotEditable(f"{name} is the name of a result")
                return name, (folder / name).read_bytes()
        raise NotEditable(f"{file} is included from elsewhere")

    source, texts = read_source(path.read_bytes(), included)
    if source.tag != "mujoco":
        raise NotEditable(f"<{source.tag}>")
    old = before.copy()
    if frozen:
        _take_over_derived(old, after)
    edit_source(source, precise_xml(old), precise_xml(after), spelled)
    assets = _assets(source, before, folder)
    names = [text.name for text in texts]
    if len(set(names)) < len(names):
        raise NotEditable("a file is included twice")
    return ModelFiles(texts[0].changed(), {t.name: t.changed() for t in texts[1:]}, assets)


def _as_it_is(element: Element) -> Element:
    return element


def _take_over_derived(old: mujoco.MjSpec, new: mujoco.MjSpec) -> None:
    """Let what was derived from the model as a whole, and was written down for good, count as unchanged."""
    written = {a.name: a for a in new.actuators}
    for actuator in old.actuators:
        other = written.get(actuator.name)
        if actuator.biastype == mujoco.mjtBias.mjBIAS_AFFINE and actuator.biasprm[2] > 0.0 and other is not None:
            actuator.biasprm = other.biasprm
    joints = {j.name: j for j in new.joints}
    for joint in old.joints:
        if np.any(joint.springdamper) and (other := joints.get(joint.name)) is not None:
            joint.springdamper, joint.stiffness, joint.damping = [0.0, 0.0], other.stiffness, other.damping


def _assets(source: SourceElement, spec: mujoco.MjSpec, folder: Path) -> dict[str, Path]:
    """Where the files of assets go, relative to the model: as they are named, or all into one folder."""
    named = list(_files_of(source))
    sources = list(_sources_of(spec))
    if len(named) != len(sources):
        raise NotEditable("assets are not those of the text")
    compilers = [e for e in source if e.tag == "compiler"]
    places = [_place(element, file, compilers) for element, file in named]
    if all(place and not place.startswith("..") and not os.path.isabs(place) for place in places):
        return dict(zip(places, sources, strict=True))
    found = dict[str, Path]()
    for compiler in compilers:
        for name in (*_FOLDERS, "strippath"):
            compiler.attrib.pop(name, None)
    for (element, file), path in zip(named, sources, strict=True):
        name = next((n for n, other in found.items() if other == path), None) or free_file(path, found)
        found[name] = path
        element.attrib[file] = f"{ASSETS}/{name}"
    return {f"{ASSETS}/{name}": path for name, path in found.items()}


def _files_of(source: SourceElement) -> Iterator[tuple[SourceElement, str]]:
    """Elements of assets, and the attributes of theirs that name files, in MuJoCo's order."""
    elements = [e for section in source if section.tag == "asset" for e in section]
    for tag in ("mesh", "hfield", "skin", "texture"):
        for element in elements:
            if element.tag == tag:
                for name in ("file", *(_SIDES if tag == "texture" else ())):
                    if name in element.attrib:
                        yield element, name


def _sources_of(spec: mujoco.MjSpec) -> Iterator[Path]:
    for some in (spec.meshes, spec.hfields, spec.skins, spec.textures):
        for owner in some:
            yield from (Path(file) for file in (owner.file, *getattr(owner, "cubefiles", ())) if file)


def _place(element: SourceElement, attribute: str, compilers: list[SourceElement]) -> str:
    own = "texturedir" if element.tag == "texture" else "meshdir"
    said = {k: v for compiler in compilers for k, v in compiler.attrib.items()}
    file = element.attrib[attribute]
    if said.get("strippath") == "true":
        file = Path(file).name
    return os.path.normpath(os.path.join(said.get(own, said.get("assetdir", "")), file))


def _is_model(files: ModelFiles, wanted: mujoco.MjModel) -> bool:
    """Whether files, put into a folder, are this model."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        for name, path in files.assets.items():
            (root / name).parent.mkdir(parents=True, exist_ok=True)
            if not (root / name).exists():
                (root / name).symlink_to(path)
        for name, text in {**files.included, "model_to_compare.xml": files.text}.items():
            (root / name).parent.mkdir(parents=True, exist_ok=True)
            (root / name).write_text(text, encoding="utf-8")
        with mujoco_warnings_suppressed():
            model = mujoco.MjModel.from_xml_path(str(root / "model_to_compare.xml"))
    return _alike(model, wanted) and _alike(model.opt, wanted.opt)


def _alike(one: Any, other: Any) -> bool:
    for name in (n for n in dir(other) if not n.startswith(("_", *_NAMES)) and not n.endswith("pathadr")):
        a, b = getattr(one, name), getattr(other, name)
        if isinstance(b, int | float | np.ndarray):
            if np.shape(a) != np.shape(b) or not np.allclose(a, b, **_CLOSE, equal_nan=True):
                return False
    return True
