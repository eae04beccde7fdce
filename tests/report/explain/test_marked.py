"""The robot with the parts of the claims marked."""

import io

import numpy as np
from PIL import Image

from estexp_jax.report.explain.marked import claimed_places, marked_of


def test_places_to_be_marked_are_those_named_or_else_the_likeliest() -> None:
    knee, tilt = {"kind": "joint", "name": "knee"}, {"kind": "environment", "name": None}
    motors, hip = {"kind": "actuator", "name": "*"}, {"kind": "joint", "name": "hip"}
    named = {"verdict": "missing_physics", "what": [knee, tilt, motors, dict(knee)], "where": [hip]}
    assert claimed_places(named) == [("joint", "knee")]
    assert claimed_places({"verdict": "unexplained", "what": [], "where": [hip, knee]}) == [("joint", "hip")]
    assert claimed_places({"verdict": "unexplained", "what": [], "where": []}) == []
    assert claimed_places({"verdict": "consistent", "what": [], "where": [hip]}) == []


def test_the_claimed_part_is_marked(arm_diagnosis, renderer: None) -> None:
    arm = arm_diagnosis.case.robot
    shares = []
    for places in ([("joint", "b")], [("joint", "a"), ("sensor", "angle"), ("joint", "b")]):
        content = marked_of(arm, places)
        assert content is not None
        picture = np.asarray(Image.open(io.BytesIO(content))).astype(int)
        assert picture.shape == (330, 840, 3)
        orange = (picture[..., 0] - picture[..., 2]) > 60
        shares.append([half.mean() for half in (orange[:, :420], orange[:, 420:])])
    lower, both = np.array(shares)
    assert (lower > 0.002).all() and (both > 1.5 * lower).all()
    assert marked_of(arm, []) is None
    assert marked_of(arm, [("environment", "gravity"), ("sensor", "no.such")]) is None
