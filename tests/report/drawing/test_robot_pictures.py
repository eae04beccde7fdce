"""Colours and camera views of robots."""

import numpy as np
import pytest

from estexp_jax.physics.effects.changes import parse_change
from estexp_jax.report.drawing.robot_pictures import colours, drawn, ground_covered, standing_view, tinted, walking_view
from tests.physics.robots import robot


def test_colours_tell_what_happened() -> None:
    quadruped = robot("quadruped")
    geoms = {quadruped.model.geom(i).name: i for i in range(quadruped.model.ngeom)}
    changes = [parse_change(text, quadruped) for text in ("part_lost@lower_f", "motor_weakness@knee_l loss=0.5")]
    rgba = colours(quadruped, [*changes, parse_change("gravity_tilt angle=0.1", quadruped)])
    assert 0.0 < rgba[geoms["foot_f"], 3] < 0.4 and rgba[geoms["foot_b"], 3] == 1.0
    assert rgba[geoms["foot_l"], 0] > 0.8 and rgba[geoms["foot_b"], 0] < 0.3
    assert (rgba[geoms["floor"]] == quadruped.model.geom_rgba[geoms["floor"]]).all()
    ghost = tinted(quadruped, (0.0, 0.0, 1.0), 0.5)
    assert ghost[geoms["torso"]].tolist() == [0.0, 0.0, 1.0, 0.5] and ghost[geoms["floor"], 3] == 1.0


def test_views_show_all_of_a_robot() -> None:
    quadruped = robot("quadruped")
    centre, radius = ground_covered(quadruped, quadruped.home()[None])
    np.testing.assert_allclose(centre, [0, 0, 0.105], atol=0.02)
    assert 0.3 < radius < 0.4
    assert walking_view("x", radius).azimuth == 110.0 and walking_view("-y", radius).azimuth == 20.0
    assert standing_view(robot("cartpole"), 1.0).distance == pytest.approx(2.4)
    assert drawn(quadruped).ntex == quadruped.model.ntex + 1  # the sky
