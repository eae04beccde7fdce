"""What differs between two descriptions of a model, put into its author's own text."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, Protocol
from xml.etree import ElementTree

from estexp_jax.physics.model.xml_elements import (
    GAINS,
    as_servo,
    degrees_of,
    element_text,
    is_angle,
    to_degrees,
)
from estexp_jax.physics.model.xml_source import NotEditable, SourceElement

Spelling = Callable[[ElementTree.Element], ElementTree.Element]
"""From an element of MuJoCo's text to one that says the same."""
Place = tuple[str, int, int]
"""What an element is, the number of its body (0: the world) or -1, and its own number there."""
_IN_BODY = {"joint": "joint", "freejoint": "joint", "geom": "geom", "site": "site", "inertial": "inertial"}
_SECTIONS = ("actuator", "sensor", "tendon", "equality", "contact", "keyframe")
_UNFOLDED = frozenset(("replicate", "composite", "flexcomp", "attach", "model", "deformable", "extension"))
_SHORT = ("kp", "kv", "dampratio", "timeconst", "area", "diameter", "bias", "gain", "inputmode")
_TURNED = ("fullinertia", "euler", "axisangle", "xyaxes", "zaxis")


class _Tree(Protocol):
    tag: str
    attrib: dict[str, str]

    def __iter__(self) -> Iterator[Any]: ...


def edit_source(source: SourceElement, before: str, after: str, spelled: Spelling) -> None:
    """Change a model's text, as the author wrote it, as MuJoCo's text of it changes.

    Args:
        source: the author's, in which changes wait to be written.
        before: MuJoCo's text of the model, bodies, joints, motors and sensors named.
        after: the same with changes.
        spelled: gives new elements as an author would write them.

    Raises:
        NotEditable: an element of one has no counterpart in the other.
    """
    trees = ElementTree.fromstring(before), ElementTree.fromstring(after)
    own, old = places(source), places(trees[0])
    if own.keys() != old.keys():
        raise NotEditable("the author's text is folded up otherwise than MuJoCo's")
    new = _as_in(old, places(trees[1]))
    in_degrees = _counts_in_degrees(source)
    gone = [own[place] for place in old if place not in new]
    for element in gone:
        if not any(element is not other and _holds(other, element) for other in gone):
            element.delete()
    for place, element in new.items():
        if place in old:
            _change(own[place], old[place], element, in_degrees)
    _change_options(source, *trees)
    _add(source, own, {p: e for p, e in new.items() if p not in old}, in_degrees, spelled)


def places(root: _Tree) -> dict[Place, Any]:
    """All elements that may change, by what they are and where.

    Raises:
        NotEditable: some are made of others when MuJoCo reads them.
    """
    found = dict[Place, Any]()
    bodies = 0

    def body(element: _Tree, number: int) -> None:
        nonlocal bodies
        counts, inner = dict[str, int](), list[_Tree]()
        for child in _unframed(element):
            if child.tag == "body":
                inner.append(child)
            elif child.tag in _IN_BODY:
                kind = _IN_BODY[child.tag]
                found[kind, number, counts.get(kind, 0)] = child
                counts[kind] = counts.get(kind, 0) + 1
        for child in inner:
            bodies += 1
            found["body", bodies, 0] = child
            body(child, bodies)

    counts = dict[str, int]()
    for section in root:
        if section.tag in _UNFOLDED:
            raise NotEditable(f"<{section.tag}>")
        if section.tag == "worldbody":
            body(section, 0)
        if section.tag in _SECTIONS:
            for child in section:
                kind = f"{section.tag}/{child.tag}" if section.tag == "contact" else section.tag
                found[kind, -1, counts.get(kind, 0)] = child
                counts[kind] = counts.get(kind, 0) + 1
    return found


def _unframed(element: _Tree) -> Iterator[Any]:
    for child in element:
        if child.tag in _UNFOLDED:
            raise NotEditable(f"<{child.tag}>")
        if child.tag == "frame":
            yield from _unframed(child)
        else:
            yield child


def _as_in(old: dict[Place, Any], new: dict[Place, Any]) -> dict[Place, Any]:
    """Elements of a changed model at the places that they had before: by name, or else by number; new ones behind."""
    bodies = {e.attrib["name"]: number for (kind, number, _), e in old.items() if kind == "body"} | {"": 0}
    named = {
        (kind, body if kind in _IN_BODY.values() else -1, e.attrib["name"]): place
        for place, e in old.items()
        if (kind := place[0]) and (body := place[1]) is not None and "name" in e.attrib
    }
    bodies_before, found = {0: 0}, dict[Place, Any]()
    more = 1 + max((number for kind, number, _ in old if kind == "body"), default=0)
    for (kind, number, _), element in new.items():
        if kind == "body":
            name = element.attrib["name"]
            bodies_before[number] = bodies.get(name, more)
            more += name not in bodies
    counts = dict[tuple[str, int], int]()
    for kind, number, k in old:
        counts[kind, number] = max(counts.get((kind, number), 0), k + 1)
    for (kind, number, k), element in new.items():
        body = -1 if number < 0 else bodies_before[number]
        if kind == "body":
            found[kind, body, 0] = element
            continue
        by_name = named.get((kind, body if kind in _IN_BODY.values() else -1, element.attrib.get("name", "")))
        place = by_name or (kind, body, k)
        if by_name is None and (place in found or ("name" in element.attrib and place in old)):
            place = (kind, body, counts.get((kind, body), 0))
        counts[kind, body] = max(counts.get((kind, body), 0), place[2] + 1)
        found[place] = element
    return found


def _change(own: SourceElement, old: _Tree, new: _Tree, in_degrees: bool) -> None:
    """Give an element of the author's what changed in MuJoCo's."""
    names = dict.fromkeys([*old.attrib, *new.attrib])
    changed = [n for n in names if old.attrib.get(n) != new.attrib.get(n)]
    if not changed:
        return
    if own.tag == "inertial":
        for name in _TURNED:
            own.attrib.pop(name, None)
        own.attrib |= new.attrib
        return
    if any(name in GAINS for name in changed) and own.tag != "general":
        if as_servo(own, new, changed):
            changed = [name for name in changed if name not in GAINS]
        else:
            _generalise(own, new)
    for name in changed:
        if name in new.attrib:
            own.attrib[name] = _in_unit(own, name, new.attrib[name], in_degrees)
        elif name in own.attrib:
            del own.attrib[name]
        elif name not in GAINS:
            raise NotEditable(f"{name} of <{own.tag}> is a default's")


def _generalise(own: SourceElement, new: _Tree) -> None:
    """Make a shortcut of an actuator the general one, which it stands for."""
    if own.tag not in ("motor", "position", "velocity", "damper"):
        raise NotEditable(f"<{own.tag}>")
    own.tag = "general"
    for name in _SHORT:
        own.attrib.pop(name, None)
    own.attrib |= {name: new.attrib[name] for name in GAINS if name in new.attrib}


def _in_unit(own: SourceElement, name: str, value: str, in_degrees: bool) -> str:
    return degrees_of(value) if in_degrees and is_angle(own, name) else value


def _counts_in_degrees(source: SourceElement) -> bool:
    said = [c.attrib["angle"] for c in source if c.tag == "compiler" and "angle" in c.attrib]
    return not said or said[-1] == "degree"


def _change_options(source: SourceElement, before: _Tree, after: _Tree) -> None:
    """Give the author's options what changed in MuJoCo's."""
    old, new = ({k: v for e in tree if e.tag == "option" for k, v in e.attrib.items()} for tree in (before, after))
    changed = {k: v for k, v in new.items() if old.get(k) != v}
    if not changed:
        return
    own = [e for e in source if e.tag == "option"]
    if not own:
        source.insert_first([element_text(ElementTree.Element("option", changed))])
        return
    for name, value in changed.items():
        there = [e for e in own if name in e.attrib]
        (there or own)[-1].attrib[name] = value


def _add(
    source: SourceElement, own: dict[Place, SourceElement], new: dict[Place, Any], in_degrees: bool, spelled: Spelling
) -> None:
    """Put what is new behind what is there: bodies into the world, the others into their bodies and sections."""
    world = [e for e in source if e.tag == "worldbody"]
    added_bodies = {number for kind, number, _ in new if kind == "body"}
    first, last, sections = list[tuple[Place, str]](), list[tuple[Place, str]](), dict[str, list[str]]()
    for place, element in new.items():
        kind, number, _ = place
        if number in added_bodies and kind != "body":
            continue
        if in_degrees:
            to_degrees(element)
        text = element_text(spelled(element))
        if kind in _IN_BODY.values() or kind == "body":
            (first if kind in ("joint", "inertial") else last).append((place, text))
        else:
            sections.setdefault(kind.partition("/")[0], []).append(text)
    for inserted, places_of in (("insert_first", first), ("insert_last", last)):
        grouped = dict[int, list[str]]()
        for (kind, number, _), text in places_of:
            grouped.setdefault(0 if kind == "body" else number, []).append(text)
        for number, texts in grouped.items():
            getattr(world[-1] if number == 0 else own["body", number, 0], inserted)(texts)
    for name, texts in sections.items():
        there = [e for e in source if e.tag == name and not e.is_closed]
        if there:
            there[-1].insert_last(texts)
        else:
            inner = "".join(f"\n    {text}" for text in texts)
            source.insert_last([f"<{name}>{inner}\n  </{name}>"])


def _holds(outer: SourceElement, inner: SourceElement) -> bool:
    return any(child is inner or _holds(child, inner) for child in outer)
