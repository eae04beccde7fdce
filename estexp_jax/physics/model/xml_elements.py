"""Elements of MuJoCo's text as authors write them: angles in degrees, actuators by their shortcuts."""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import Any
from xml.etree import ElementTree

_ANGLES = ("range", "ref", "springref")
GAINS = ("dyntype", "dynprm", "gaintype", "gainprm", "biastype", "biasprm", "actdim", "input")
"""Attributes of an actuator that its shortcuts stand for."""


def is_angle(element: Any, name: str) -> bool:
    """Whether an attribute of an element is an angle."""
    return element.tag == "joint" and name in _ANGLES and element.attrib.get("type", "hinge") == "hinge"


def degrees_of(value: str) -> str:
    """Numbers in radians as such in degrees."""
    return " ".join(repr(math.degrees(float(x))) for x in value.split())


def as_servo(own: Any, new: Any, changed: Collection[str]) -> bool:
    """Give a position servo of the author's the gains and the lag that it has now, if it still is one.

    Args:
        own: the author's element, changed in place.
        new: MuJoCo's.
        changed: attributes of MuJoCo's element that changed.
    """
    gain, bias, filtered = (new.attrib.get(name, "").split() for name in ("gainprm", "biasprm", "dyntype"))
    changed = [name for name in changed if name in GAINS and name != "actdim"]
    known = {"gainprm": len(gain) == 1, "biasprm": len(bias) == 3 and float(bias[0]) == 0.0 >= float(bias[2])}
    known |= {"dyntype": filtered == ["filterexact"], "dynprm": "dyntype" in new.attrib}
    matching = not (gain and bias) or float(gain[0]) == -float(bias[1])
    if own.tag != "position" or not matching or not all(known.get(name, False) for name in changed):
        return False
    if "gainprm" in changed:
        own.attrib["kp"] = gain[0]
    if "biasprm" in changed:
        own.attrib.pop("dampratio", None)
        own.attrib["kv"] = bias[2].removeprefix("-")
    if "dynprm" in changed or "dyntype" in changed:
        own.attrib["timeconst"] = new.attrib["dynprm"].split()[0]
    return True


def to_degrees(element: Any) -> None:
    """Let new hinges of an element of MuJoCo's count in degrees, in place."""
    for joint in element.iter("joint"):
        for name in [name for name in joint.attrib if is_angle(joint, name)]:
            joint.attrib[name] = degrees_of(joint.attrib[name])


def element_text(element: Any) -> str:
    """An element as text."""
    element.tail = None
    return ElementTree.tostring(element, encoding="unicode").strip().replace(" />", "/>")
