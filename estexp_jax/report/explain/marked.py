"""The robot with marked parts, at which something is missing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from estexp_jax.physics.model.robot import Robot
from estexp_jax.report.drawing.film import strip
from estexp_jax.report.drawing.gl import Shot, render_shots
from estexp_jax.report.drawing.robot_pictures import MARK, drawn, ground_covered, part_at, standing_view, tinted

_KINDS = ("body", "joint", "actuator", "sensor")
_SIZE = (420, 330)
_GREY = (0.55, 0.6, 0.65)
_TURN, _RAISE = 55.0, -25.0
"""Rotation of the second view, degrees."""
_AWAY = 1.2
"""Factor of the camera's distance, so that nothing is cut off."""


def claimed_places(findings: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Kind and name of each place in the claims, or of the most likely one without claims; not the environment."""
    if findings["verdict"] == "consistent":
        return []
    places = findings["what"] or findings["where"][:1]
    return list(dict.fromkeys((p["kind"], p["name"]) for p in places if p["name"] not in (None, "*")))


def marked_of(robot: Robot, places: Sequence[tuple[str, str]]) -> bytes | None:
    """Two views (JPEG) of a robot at home in grey, with the parts at some places in orange.

    Args:
        robot: the robot.
        places: kind and name of each. The part of a joint, motor or sensor is the body at it.

    Returns:
        The picture; None if no place is at a visible part.

    Raises:
        NoGlError: no renderer works here.
    """
    model, rgba = robot.model, tinted(robot, _GREY, 1.0)
    known = [(kind, name) for kind, name in places if kind in _KINDS and name in robot.names(kind)]
    parts = [part for part in (part_at(robot, *place) for place in known) if part is not None]
    geoms = np.isin(model.geom_bodyid, parts) & (rgba[:, 3] > 0.0)
    if not geoms.any():
        return None
    rgba[geoms, :3] = MARK
    qpos = robot.home()[None, None]
    centre, radius = ground_covered(robot, qpos[0])
    view = standing_view(robot, _AWAY * radius)
    other = view._replace(azimuth=view.azimuth + _TURN, elevation=max(-80.0, view.elevation + _RAISE))
    shots = [Shot(qpos, rgba[None], centre[None], *v) for v in (view, other)]
    pictures = render_shots(drawn(robot), shots, width=_SIZE[0], height=_SIZE[1])
    return strip([[frames[0] for frames in pictures]])
