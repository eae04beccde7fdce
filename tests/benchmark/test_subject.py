"""The robots that are raced."""

from dataclasses import replace
from pathlib import Path

import pytest

from estexp_jax.benchmark.subject import BenchmarkRobots, load
from estexp_jax.errors import InputError
from tests.physics.robots import PENDULUM


def test_feet_alone_touch() -> None:
    robot, nominal = load(None, feet=True), load(None, feet=False)
    touching = [n for n, a in zip(robot.names("geom"), robot.model.geom_conaffinity, strict=True) if a and n != "floor"]
    assert sorted(n for n in touching if n.startswith("foot")) == ["foot_b", "foot_f", "foot_l", "foot_r"]
    assert not [n for n in touching if n.startswith(("knee", "corner"))]
    assert nominal.model.geom_conaffinity.sum() > robot.model.geom_conaffinity.sum()


def test_a_robot_that_cannot_travel_is_refused(race, tmp_path) -> None:
    arm = Path(tmp_path / "arm.xml")
    arm.write_text(PENDULUM)
    with pytest.raises(InputError, match="cannot travel"):
        BenchmarkRobots(replace(race, model=str(arm)))
