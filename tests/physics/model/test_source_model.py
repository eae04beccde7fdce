"""A changed model is its author's own text: only what changed differs, and it is the model that was wanted."""

from __future__ import annotations

import difflib
from pathlib import Path

import mujoco
import numpy as np
import pytest

from estexp_jax.physics.effects.changes import parse_change
from estexp_jax.physics.effects.new_elements import passive_motor_text
from estexp_jax.physics.effects.written import written
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.model.source_model import ModelFiles, changed_source
from tests.physics.meshes import write_box
from tests.versions import needs_mujoco_4

pytestmark = needs_mujoco_4

MODEL = """<?xml version="1.0"?>
<!-- Arm of the lab -- second version -->
<mujoco model="arm">
  <include file="parts/defaults.xml"/>
  <compiler meshdir="{meshes}" autolimits="true"/>   <!-- degrees -->
  <asset>
    <mesh name="link" file="link.stl"/>
  </asset>
  <worldbody>
    <geom name="floor" type="plane" size="1 1 1"/>
    <!-- the upper arm -->
    <body name="upper" pos="0 0 1">
      <joint name="shoulder" axis="0 1 0"   class="strong" range="-90 90"/>
      <geom type="mesh" mesh="link" mass="1" contype="0" conaffinity="0"/>
      <frame pos="0 0 -.3">
        <body name="lower">
          <joint name="elbow" axis="0 1 0" springref='5' stiffness="0.5"/>  <!-- a spring -->
          <geom type="capsule" size=".02 .1" mass="0.3"/>
        </body>
      </frame>
    </body>
  </worldbody>
  <include file="parts/drives.xml"/>
  <keyframe><key name="home" qpos="0.1 0.2" ctrl="0.1 0"/></keyframe>
</mujoco>
"""
DEFAULTS = """<mujocoinclude>
  <option timestep="0.004"/>
  <default>
    <joint damping="0.1"/>
    <default class="strong">
      <joint armature="0.01" frictionloss="0.05"/>
      <position kp="20" dampratio="1"/>
    </default>
  </default>
</mujocoinclude>
"""
DRIVES = """<mujocoinclude>
  <actuator>
    <position name="lift" joint="shoulder" class="strong" forcerange="-20 20"/>
    <motor joint="elbow" gear="2"/> <!-- no name -->
  </actuator>
  <sensor><jointpos name="angle" joint="shoulder"/></sensor>
</mujocoinclude>
"""


@pytest.fixture(params=["meshes", "../shapes"])
def arm(request, tmp_path) -> Robot:
    root = tmp_path / "lab"
    write_box(root / "robot" / request.param / "link.stl")
    for name, text in {
        "robot.xml": MODEL.format(meshes=request.param),
        "parts/defaults.xml": DEFAULTS,
        "parts/drives.xml": DRIVES,
    }.items():
        (root / "robot" / name).parent.mkdir(parents=True, exist_ok=True)
        (root / "robot" / name).write_text(text)
    return Robot.from_xml(root / "robot" / "robot.xml", root)


CASES = {
    "coulomb_friction@shoulder T=0.3": 1,
    "viscous_friction@elbow c=0.2": 1,
    "joint_stiffness@elbow k=1 q0=0.2": 1,
    "joint_limit@elbow low=-1 high=1.2": 1,
    "armature@elbow I=0.01": 2,
    "command_delay@lift delay=0.02": 1,
    "actuator_lag@lift tau=0.03": 1,
    "actuator_lag@* tau=0.03": 2,
    "motor_weakness@lift loss=0.2": 1,
    "motor_weakness@actuator_1 loss=0.3": 1,
    "torque_saturation@lift limit=3": 1,
    "sensor_delay@angle delay=0.0101": 1,
    "gravity_tilt angle=0.1 axis=0.3": 1,
    "ground_friction mu=0.4": 3,
    "body_mass@lower dm=0.1": 2,
    "com_shift@upper x=0.01": 2,
    "joint_offset@elbow offset=0.05": 1,
    "cogging@elbow A=0.1 n=5 phase=0.2": 1,
    "torque_offset@elbow T=0.2 + asymmetric_friction@shoulder T=0.2 a=0.3": 3,
    "hysteresis@elbow T=0.2 sigma=10": 1,
    "crosstalk@shoulder from=2 g=0.3": 7,
    "external_force@lower x=1 z=2 k=0": 3,
    "external_force@lower x=1 z=2 k=3": 9,
    "joint_compliance@elbow k=50 d=0.1 I=0.01": 12,
    "backlash@shoulder half_gap=0.03": 13,
    "part_lost@lower": 6,
}
"""What is changed, and the most lines that differ or are new."""


@pytest.mark.parametrize("text", CASES)
def test_only_what_changed_differs_and_it_is_the_wanted_model(arm: Robot, text: str, tmp_path: Path) -> None:
    changes = [parse_change(part, arm) for part in text.split(" + ")]
    spec = written(arm, changes)
    spec.compile()
    found = changed_source(Path(arm.source), arm.spec.copy(), spec, spelled=passive_motor_text)
    assert found is not None
    folder = Path(arm.source).parent
    lines, moved = list[str](), [] if "meshes/link.stl" in found.assets else ["<compiler", "link.stl"]
    for name, new in {"robot.xml": found.text, **found.included}.items():
        old = (folder / name).read_text()
        lines += [line for line in difflib.ndiff(old.splitlines(), new.splitlines()) if line[:1] in "+-"]
        assert "part_lost" in text or all(comment in new for comment in _comments(old))
    lines = [line for line in lines if not any(word in line for word in moved)]
    assert len([line for line in lines if line[0] == "+"]) <= CASES[text]
    model = _loaded(found, tmp_path / "out")
    wanted = spec.compile()
    for name in ("qpos0", "dof_damping", "body_mass", "actuator_biasprm", "actuator_gainprm", "tendon_stiffness"):
        np.testing.assert_allclose(getattr(model, name), getattr(wanted, name), rtol=1e-7, atol=1e-12, err_msg=name)
    assert [model.actuator(a).name for a in range(model.nactuator)][:1] == ["lift"]


def _comments(text: str) -> list[str]:
    return [part.partition("-->")[0] for part in text.split("<!--")[1:]]


def _loaded(files: ModelFiles, folder: Path) -> mujoco.MjModel:
    for name, source in files.assets.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(source.read_bytes())
    for name, text in {**files.included, "model.xml": files.text}.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return mujoco.MjModel.from_xml_path(str(folder / "model.xml"))


def test_nothing_changed_is_the_text_itself(arm: Robot) -> None:
    spec = arm.spec.copy()
    spec.compile()
    found = changed_source(Path(arm.source), arm.spec.copy(), spec)
    assert found is not None
    if "meshes/link.stl" in found.assets:
        assert found.text == Path(arm.source).read_text()
    assert found.included == {"parts/defaults.xml": DEFAULTS, "parts/drives.xml": DRIVES}


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('<frame pos="0 0 -.3">', '<replicate count="1" offset="0 0 1">'),
        ('file="parts/defaults.xml"', 'file="../robot/parts/defaults.xml"'),
        ("<mujoco model", "<mujoco  other='é' model"),
    ],
)
def test_what_cannot_be_changed_in_single_places_is_left_to_mujoco(arm: Robot, old: str, new: str) -> None:
    spec = written(arm, [parse_change("coulomb_friction@shoulder T=0.3", arm)])
    spec.compile()
    text = Path(arm.source).read_text().replace(old, new)
    Path(arm.source).write_bytes(text.encode("latin-1"))
    assert changed_source(Path(arm.source), arm.spec.copy(), spec) is None


def test_an_included_file_with_the_name_of_a_result_is_left_to_mujoco(arm: Robot) -> None:
    spec = arm.spec.copy()
    spec.compile()
    assert changed_source(Path(arm.source), arm.spec.copy(), spec, taken=("parts/drives.xml",)) is None


def test_a_default_limit_does_not_limit_what_is_added(arm: Robot) -> None:
    path = Path(arm.source).parent / "parts" / "defaults.xml"
    path.write_text(DEFAULTS.replace("<joint damping", '<general forcerange="-0.05 0.05"/>\n    <joint damping'))
    robot = Robot.from_xml(arm.source, path.parents[2])
    spec = written(robot, [parse_change("cogging@elbow A=0.1 n=5 phase=0.2", robot)])
    spec.compile()
    found = changed_source(Path(arm.source), robot.spec.copy(), spec, spelled=passive_motor_text)
    assert found is not None and 'forcelimited="false"' in found.included["parts/drives.xml"]
