"""Units of what acts on a joint: those of a hinge, and what stands for them at a slide."""

from __future__ import annotations

import re

from estexp_jax.physics.effects.sites import is_slide
from estexp_jax.physics.model.robot import Robot

_SLIDES = {
    "N m s2/rad2": "N s2/m2",
    "N m s/rad": "N s/m",
    "N m/rad3": "N/m3",
    "N m/rad2": "N/m2",
    "N m/rad": "N/m",
    "s2/rad2": "s2/m2",
    "kg m2": "kg",
    "rad/s": "m/s",
    "1/rad": "1/m",
    "N m": "N",
    "rad": "m",
}
_UNIT = re.compile("|".join(rf"(?<![\w.]){re.escape(unit)}(?!\w)" for unit in _SLIDES))


def unit_at(robot: Robot, kind: str, name: str | None, text: str) -> str:
    """A unit, or a sentence with units, of something at an element: those of a slide where it acts on one.

    Args:
        robot: the robot.
        kind: of element.
        name: the element's; None or that of no single one: nothing changes.
        text: with the units of a hinge.
    """
    joint = _joint(robot, kind, name)
    return text if joint is None or not is_slide(robot, joint) else on_slide(text)


def on_slide(text: str) -> str:
    """A text about a hinge, with the units of a slide."""
    return _UNIT.sub(lambda found: _SLIDES[found.group()], text)


def _joint(robot: Robot, kind: str, name: str | None) -> str | None:
    names = robot.names("joint")
    if kind == "joint":
        return name if name in names else None
    if kind == "actuator" and name in robot.names("actuator"):
        index = robot.joint_of_actuator(robot.index("actuator", name))
        return None if index is None else names[index]
    return None
