"""The explained model as a file, with the meshes that belong to it."""

import mujoco

from estexp_jax.discovery.export import explained_model
from estexp_jax.physics.effects.changes import Change, parse_change
from estexp_jax.physics.model.robot import Robot
from tests.physics.meshes import urdf, write_box


def test_the_explained_model_loads_from_anywhere(tmp_path):
    write_box(tmp_path / "robot" / "meshes" / "link.stl")
    (tmp_path / "robot" / "arm.urdf").write_text(urdf("package://arm/meshes/link.stl"))
    robot = Robot.from_xml(tmp_path / "robot" / "arm.urdf")
    change = parse_change("coulomb_friction@elbow T=0.5", robot)
    files = explained_model(robot, [change], [], 4, tmp_path / "out")
    (tmp_path / "assets").mkdir()
    for name, source in files.assets.items():
        (tmp_path / name).write_bytes(source.read_bytes())
    (tmp_path / "model_explained.xml").write_text(files.text)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "model_explained.xml"))
    assert model.nmesh == 1 and model.dof_frictionloss.tolist() == [0.0, 0.5]


def test_the_users_own_files_are_not_written_over(tmp_path):
    (tmp_path / "arm.xml").write_text(f"<!-- mine -->\n{ARM}")
    robot = Robot.from_xml(tmp_path / "arm.xml", tmp_path)
    change = parse_change("coulomb_friction@elbow T=0.5", robot)
    beside, elsewhere = (explained_model(robot, [change], [], 1, folder) for folder in (tmp_path, tmp_path / "out"))
    assert "<!-- mine -->" in elsewhere.text and "<!-- mine -->" not in beside.text
    for files in (beside, elsewhere):
        assert mujoco.MjModel.from_xml_string(files.text).dof_frictionloss.tolist() == [0.5]


def test_what_is_left_out_is_told_with_its_reason(tmp_path):
    robot = Robot.from_string(ARM)
    left_out = Change("dead_band", "lift", {"half_width": 0.1})
    text = explained_model(robot, [], [(left_out, "MuJoCo has no element for it")], 1).text
    assert text.startswith("<!--") and "dead_band@lift); MuJoCo has no element for it." in text


ARM = """<mujoco>
  <worldbody>
    <body><joint name="elbow" axis="0 1 0"/><geom size="0.1" pos="0.2 0 0"/></body>
  </worldbody>
  <actuator><motor name="lift" joint="elbow"/></actuator>
</mujoco>
"""
