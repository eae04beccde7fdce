"""The explained model as a file, with the meshes that belong to it."""

import mujoco

from estexp_jax.discovery.export import explained_xml
from estexp_jax.physics.effects.changes import parse_change
from estexp_jax.physics.model.robot import Robot
from tests.physics.meshes import urdf, write_box


def test_the_explained_model_loads_from_anywhere(tmp_path):
    write_box(tmp_path / "robot" / "meshes" / "link.stl")
    (tmp_path / "robot" / "arm.urdf").write_text(urdf("package://arm/meshes/link.stl"))
    robot = Robot.from_xml(tmp_path / "robot" / "arm.urdf")
    change = parse_change("coulomb_friction@elbow T=0.5", robot)
    text, files = explained_xml(robot, [change], [], 4)
    (tmp_path / "assets").mkdir()
    for name, source in files.items():
        (tmp_path / "assets" / name).write_bytes(source.read_bytes())
    (tmp_path / "model_explained.xml").write_text(text)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "model_explained.xml"))
    assert model.nmesh == 1 and model.dof_frictionloss.tolist() == [0.0, 0.5]
