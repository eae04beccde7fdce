"""Meshes that overlap from the start are no contacts, and it is said."""

import numpy as np
import pytest

from estexp_jax.physics.engines.mjx.capabilities import reduced_to_mjx
from estexp_jax.physics.model.clearance import without_collisions
from estexp_jax.physics.model.collision_pairs import overlapping_bodies
from estexp_jax.physics.model.robot import Robot

CUBE = " ".join(f"{x} {y} {z}" for x in (-0.05, 0.05) for y in (-0.05, 0.05) for z in (-0.05, 0.05))
MESH, BOX = 'type="mesh" mesh="cube"', 'type="box" size="0.05 0.05 0.05"'


def arm(deep: float, *, shape: str = MESH, base: str = '<joint name="first" axis="1 0 0"/>') -> Robot:
    """Three parts; the last reaches `deep` m into the first, and the middle one touches nothing."""
    return Robot.from_string(
        f"""<mujoco><asset><mesh name="cube" vertex="{CUBE}"/></asset><worldbody>
        <geom name="ground" {shape} pos="0 0 {deep - 0.1}"/>
        <body name="one">{base}<geom {shape} mass="1"/>
         <body name="two"><joint name="second" axis="1 0 0"/><geom size="0.01" mass="1" contype="0" conaffinity="0"/>
          <body name="three" pos="{0.1 - deep} 0 0"><joint name="third" axis="1 0 0"/><geom {shape} mass="1"/></body>
        </body></body></worldbody></mujoco>""",
        "arm.xml",
    )


@pytest.mark.parametrize(
    ("deep", "shape", "left_out"), [(0.005, MESH, True), (0.0005, MESH, False), (0.005, BOX, False)]
)
def test_meshes_that_overlap_at_home_are_left_out_and_named(deep: float, shape: str, left_out: bool) -> None:
    robot = arm(deep, shape=shape)
    world, one, three = (robot.index("body", name) for name in ("world", "one", "three"))
    pairs = ((world, one), (world, three), (one, three)) if left_out else ()
    assert overlapping_bodies(robot) == pairs
    model, told = reduced_to_mjx(robot)
    assert model.nexclude == len(pairs)
    assert [("world and one" in line, "one and three" in line, "overlap" in line) for line in told] == [(True,) * 3] * (
        left_out
    )


@pytest.mark.parametrize("deep", [0.005, 0.0005])
def test_what_overlaps_at_home_stays_left_out_wherever_the_robot_moves(deep: float) -> None:
    robot = arm(deep)
    moves = np.zeros((50, 3)) + 0.5 * np.sin(np.linspace(0.0, 6.0, 50))[:, None]
    pressed = robot.index("body", "one"), robot.index("body", "three")
    assert (pressed in without_collisions(robot, [moves])) == (deep > 0.001)


def test_what_a_robot_may_stand_on_stays() -> None:
    robot = arm(0.005, base="<freejoint/>")
    assert overlapping_bodies(robot) == ((robot.index("body", "one"), robot.index("body", "three")),)


@pytest.mark.parametrize(("shape", "apart"), [(MESH, True), (BOX, False)])
def test_meshes_are_near_only_where_they_all_but_touch(shape: str, apart: bool) -> None:
    """They pass each other at 1 cm."""
    robot = Robot.from_string(
        f"""<mujoco><asset><mesh name="cube" vertex="{CUBE}"/></asset><worldbody>
        <body name="still" pos="0.11 0 0"><joint axis="1 0 0" type="slide"/><geom {shape} mass="1"/></body>
        <body name="moves" pos="0 0 1"><joint type="slide"/><geom {shape} mass="1"/></body></worldbody></mujoco>"""
    )
    passing = np.stack([np.zeros(50), np.linspace(0.0, -2.0, 50)], axis=1)
    assert ((1, 2) in without_collisions(robot, [passing])) == apart
