"""What MJX lacks: left out and said where it hardly matters, refused where a robot may stand on it."""

from __future__ import annotations

from itertools import combinations_with_replacement

import mujoco
import numpy as np
import pytest
from mujoco import mjx

from estexp_jax.errors import InputError
from estexp_jax.physics.engines.mjx.capabilities import APART, reduced_to_mjx
from estexp_jax.physics.engines.mjx.model import mjx_model
from estexp_jax.physics.model.robot import Robot

ASSETS = """<asset><mesh name="rock" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/>
<hfield name="hills" nrow="2" ncol="2" size="1 1 1 1" elevation="0 1 1 0"/></asset>"""
SHAPES = {
    "plane": 'type="plane" size="1 1 1"',
    "hfield": 'type="hfield" hfield="hills"',
    "sphere": 'size=".1"',
    "capsule": 'type="capsule" size=".1 .1"',
    "ellipsoid": 'type="ellipsoid" size=".1 .2 .3"',
    "cylinder": 'type="cylinder" size=".1 .1"',
    "box": 'type="box" size=".1 .1 .1"',
    "mesh": 'type="mesh" mesh="rock"',
}
ARM = f"""<mujoco>{ASSETS}<worldbody><geom name="table" type="box" size="1 1 .1" pos="0 0 -2"/>
<body name="upper"><joint name="shoulder"/><geom type="capsule" size=".1 .1"/>
 <body name="lower" pos="1 0 0"><joint name="elbow"/><geom {SHAPES["mesh"]}/>
  <body name="hand" pos="1 0 0"><joint name="wrist"/><geom name="barrel" {SHAPES["cylinder"]}/>
   <body name="tip" pos="1 0 0"><joint name="turn"/><geom name="point" {SHAPES["ellipsoid"]}/></body></body></body>
</body></worldbody><actuator><motor joint="elbow"/></actuator></mujoco>"""


@pytest.mark.parametrize(("one", "other"), list(combinations_with_replacement(SHAPES, 2)), ids="-".join)
def test_shapes_that_mjx_cannot_let_touch_are_those_listed(one: str, other: str) -> None:
    fixed = ("plane", "hfield")
    if one in fixed and other in fixed:
        pytest.skip("both belong to the world")
    first = f"<geom {SHAPES[one]}/>" if one in fixed else f"<body><joint/><geom {SHAPES[one]}/></body>"
    xml = f"<mujoco>{ASSETS}<worldbody>{first}<body><freejoint/><geom {SHAPES[other]}/></body></worldbody></mujoco>"
    model = mujoco.MjModel.from_xml_string(xml)
    try:
        mjx.make_data(mjx.put_model(model))
    except (NotImplementedError, ValueError):
        able = False
    else:
        able = True
    named = {tuple(kind.name.removeprefix("mjGEOM_").lower() for kind in pair) for pair in APART}
    assert able == ((one, other) not in named)


def test_an_arms_contacts_that_mjx_lacks_are_left_out_and_named() -> None:
    robot = Robot.from_string(ARM)
    model, left_out = reduced_to_mjx(robot)
    excluded = {(int(s) >> 16, int(s) & 0xFFFF) for s in model.exclude_signature}
    index = {name: robot.index("body", name) for name in ("world", "lower", "hand", "tip")}
    pairs = {("world", "hand"), ("world", "tip"), ("lower", "tip")}  # lower and hand, hinged together, never touch
    assert excluded == {tuple(sorted((index[a], index[b]))) for a, b in pairs}
    [told] = left_out
    assert "world and hand, world and tip, lower and tip" in told
    assert "none of a cylinder with a box or of an ellipsoid with a box or of an ellipsoid with a mesh" in told
    assert not robot.model.nexclude
    assert mjx_model(robot, ()).model.nq == 4


def test_all_else_of_a_model_is_kept() -> None:
    robot = Robot.from_string(ARM)
    model = reduced_to_mjx(robot).model
    for field in ("geom_size", "body_mass", "body_inertia", "jnt_axis", "actuator_gainprm", "geom_contype"):
        np.testing.assert_array_equal(getattr(model, field), getattr(robot.model, field))


def test_a_robot_that_may_stand_on_what_mjx_lacks_is_refused() -> None:
    xml = ARM.replace('<joint name="shoulder"/>', "<freejoint/>")
    with pytest.raises(InputError, match=r"walker.xml: MJX has no contact of an? \w+ with an? \w+: .*; make one"):
        reduced_to_mjx(Robot.from_string(xml, "walker.xml"))


@pytest.mark.parametrize("base", ['<joint name="shoulder"/>', "<freejoint/>"])
def test_contacts_that_are_switched_off_are_not_missed(base: str) -> None:
    xml = ARM.replace("<worldbody>", '<option><flag contact="disable"/></option><worldbody>')
    robot = Robot.from_string(xml.replace('<joint name="shoulder"/>', base))
    assert reduced_to_mjx(robot).left_out == ()
    mjx_model(robot, ())


@pytest.mark.parametrize(
    ("option", "solver", "integrator", "lines"),
    [
        ("", "NEWTON", "EULER", 0),
        ('solver="PGS"', "NEWTON", "EULER", 1),
        ('integrator="implicit"', "NEWTON", "IMPLICITFAST", 1),
        ('integrator="implicit" density="1.2" solver="PGS"', "NEWTON", "EULER", 2),
        ('integrator="implicitfast" viscosity="1e-5"', "NEWTON", "EULER", 1),
        ('integrator="implicitfast" solver="CG"', "CG", "IMPLICITFAST", 0),
    ],
)
def test_solver_and_integrator_are_replaced_by_what_mjx_has(
    option: str, solver: str, integrator: str, lines: int
) -> None:
    xml = f"""<mujoco><option {option}><flag energy="enable"/></option><worldbody><body><joint name="hinge"/>
      <geom size=".1" pos=".3 0 0"/></body></worldbody></mujoco>"""
    robot = Robot.from_string(xml)
    option_of = reduced_to_mjx(robot).model.opt
    assert mujoco.mjtSolver(option_of.solver).name == f"mjSOL_{solver}"
    assert mujoco.mjtIntegrator(option_of.integrator).name == f"mjINT_{integrator}"
    assert len(reduced_to_mjx(robot).left_out) == lines
    mjx_model(robot, ())


def test_margins_of_meshes_are_left_out() -> None:
    robot = Robot.from_string(ARM.replace('name="barrel"', 'name="barrel" margin="0.01"'))
    model, left_out = reduced_to_mjx(robot)
    assert not model.geom_margin.any() and any("margins" in line for line in left_out)
    mjx_model(robot, ())
