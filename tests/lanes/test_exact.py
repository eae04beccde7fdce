"""Lanes solve the same equations as MuJoCo: one step, in double precision, agrees to rounding."""

import copy
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import jax
import mujoco
import numpy as np
import pytest

from estexp_jax.package_data import model_path
from estexp_jax.physics.effects.changes import parse_change
from estexp_jax.physics.model.robot import Robot
from tests.lanes.lanes_twin import exact, stepped, visited
from tests.physics.reference import mapping, recompiled
from tests.physics.robots import robot

LARGEST = 1e-9
N = 256

BOXES = """
<mujoco>
  <option timestep="0.002" integrator="implicitfast"/>
  <worldbody>
    <body pos="0.1 0 0.05" euler="5 3 0"><geom name="slope" type="plane" size="0 0 1" margin="0.002"/>
      <site name="mark" pos="0.1 0.2 0.3" euler="10 20 30"/>
    </body>
    <body name="box" pos="0 0 0.3">
      <freejoint/>
      <geom type="box" size="0.1 0.07 0.05" friction="0.6 0.01 0.01" solref="0.03 0.8" solimp="0.8 0.99 0.01 0.3 3"/>
      <site name="inside" type="box" size="0.11 0.08 0.06" pos="0 0 0.001"/>
      <body name="arm" pos="0.1 0 0">
        <joint name="swing" axis="0 1 0.2" pos="0.01 0 0.02" stiffness="0.5" springref="0.2" frictionloss="0.03"/>
        <geom type="capsule" size="0.02 0.1" euler="90 0 0" pos="0.1 0 0" condim="1" priority="1"/>
        <site name="hand" type="capsule" size="0.03 0.12" euler="90 10 0" pos="0.1 0 0"/>
        <body name="tool" pos="0.1 0.1 0" euler="20 -10 5">
          <joint name="slide" type="slide" axis="1 0 0.3" damping="0.4" range="-0.02 0.05" limited="true"/>
          <geom type="sphere" size="0.03" solref="-900 -30"/>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position name="servo" joint="swing" kp="3" kv="0.1" forcerange="-1 1"/>
    <general name="push" joint="slide" gear="2" gaintype="affine" gainprm="1 0.5 -0.2"
             biastype="affine" biasprm="0.1 -2 -0.3"/>
    <motor name="second" joint="slide" ctrlrange="-0.5 0.5" ctrllimited="true"/>
  </actuator>
  <sensor>
    <touch site="inside"/> <touch site="hand"/> <accelerometer site="hand"/> <gyro site="hand"/>
    <velocimeter site="hand"/> <framepos objtype="site" objname="hand"/>
    <framelinvel objtype="body" objname="tool"/>
    <frameangvel objtype="xbody" objname="arm"/> <subtreecom body="arm"/> <subtreecom body="box"/>
    <jointpos joint="swing"/> <jointvel joint="slide"/> <actuatorfrc actuator="servo"/>
    <jointactuatorfrc joint="slide"/>
    <framequat objtype="site" objname="hand"/> <framequat objtype="xbody" objname="arm"/>
    <framequat objtype="body" objname="tool"/> <framexaxis objtype="site" objname="hand"/>
    <frameyaxis objtype="xbody" objname="arm"/> <framezaxis objtype="body" objname="tool"/>
    <subtreelinvel body="arm"/> <subtreelinvel body="box"/> <framequat objtype="xbody" objname="box"/>
    <framepos objtype="site" objname="mark"/> <framequat objtype="site" objname="mark"/> <gyro site="mark"/>
  </sensor>
</mujoco>
"""

DAMAGES: dict[str, Sequence[str]] = {
    "all at once": (
        "body_mass@upper_b dm=0.125",
        "motor_weakness@knee_l loss=0.5",
        "joint_jam@hip_r f=0.5",
        "gravity_tilt angle=0.5",
        "part_lost@lower_f",
    ),
    "intact": (),
    "mass": ("body_mass@upper_b dm=0.125",),
    "motor": ("motor_weakness@knee_l loss=0.5",),
    "jam": ("joint_jam@hip_r f=0.5",),
    "tilt": ("gravity_tilt angle=0.5",),
    "part": ("part_lost@lower_f",),
    "limb": ("part_lost@upper_l",),
    "part and motor": ("part_lost@lower_b", "motor_weakness@hip_f loss=0.25"),
}


def first_quick(first: str, *others: str) -> list[Any]:
    """The first one by default, the others where slow tests run: each is compiled for itself."""
    return [first, *(pytest.param(name, marks=pytest.mark.slow) for name in others)]


@pytest.fixture(autouse=True)
def double_precision():
    with jax.enable_x64(True):
        yield


def _agrees(model: mujoco.MjModel, *, qpos: np.ndarray | None = None, n: int = N) -> None:
    states = visited(exact(model), n, seed=11, qpos=qpos)
    ours = stepped(model, states)
    assert ours.fast, "the options did not reach XLA"
    assert np.abs(ours.qvel - states.next_qvel).max() < LARGEST
    assert np.abs(ours.qpos - states.next_qpos).max() < LARGEST
    np.testing.assert_allclose(ours.sensordata, states.sensordata, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("damage", first_quick(*DAMAGES))
def test_the_quadruped_with_damage_recompiled(damage: str) -> None:
    subject = robot("quadruped")
    changed = recompiled(subject, [parse_change(text, subject) for text in DAMAGES[damage]])
    _agrees(changed, qpos=subject.home()[mapping(subject, changed).qpos])


@pytest.mark.parametrize("name", first_quick("boxes", "pendulum", "cartpole", "leg"))
def test_other_robots(name: str) -> None:
    if name == "leg":
        model = mujoco.MjModel.from_xml_path(str(model_path("leg")))
    else:
        model = Robot.from_string(BOXES).model if name == "boxes" else robot(name).model
    _agrees(copy.deepcopy(model))


@pytest.mark.parametrize("device", first_quick("xl330", "double_pendulum", "so101"))
def test_the_models_of_real_devices(device: str, real_data: Path) -> None:
    _agrees(mujoco.MjModel.from_xml_path(str(real_data / device / "nominal.xml")))


def test_the_boxes_meet_all_kinds_of_contact() -> None:
    model = Robot.from_string(BOXES).model
    states = visited(exact(copy.deepcopy(model)), N, seed=11)
    assert states.contacts.max() >= 5 and states.contacts.min() == 0
    assert (states.sensordata[:, 0] > 0).any() and (states.sensordata[:, 1] > 0).any()
