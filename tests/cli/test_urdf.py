"""URDFs and meshes through the commands: what they lack is said, a first MJCF written, their files taken along."""

import json

import mujoco
import numpy as np
import pytest

from estexp_jax.cli.main import main
from estexp_jax.discovery.export import explained_xml
from estexp_jax.physics.effects.changes import parse_change
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recordings.write import write_csv
from tests.physics.meshes import urdf, write_box


@pytest.fixture
def arm(tmp_path, monkeypatch):
    """A folder with arm.urdf and its mesh; the current one."""
    write_box(tmp_path / "robot" / "meshes" / "link.stl")
    (tmp_path / "robot" / "arm.urdf").write_text(urdf("package://arm/meshes/link.stl"))
    monkeypatch.chdir(tmp_path / "robot")
    return tmp_path


def test_a_urdf_becomes_a_robot_and_keeps_its_meshes(arm, capsys):
    assert main(["check", "arm.urdf", "--init", "--out", "../first"]) == 0
    assert "put the gains of your servos into it" in capsys.readouterr().out
    first = Robot.from_xml(arm / "first" / "arm.xml")
    assert first.names("actuator") == ("shoulder", "elbow") and first.names("sensor") == ("shoulder_pos", "elbow_pos")
    np.testing.assert_allclose(first.model.actuator_gainprm[:, 0], 100.0)  # 10 N m at 0.1 rad
    np.testing.assert_allclose(first.model.actuator_ctrlrange, [[-1.5, 1.5]] * 2)
    assert (first.model.actuator_biasprm[:, 2] < 0.0).all()
    assert main(["check", "arm.urdf", "--init", "--out", "../first"]) == 2
    assert "arm.xml: exists already" in capsys.readouterr().err

    few = ["--duration", "0.2", "--rate", "100", "--effect", "coulomb_friction@elbow T=0.5"]
    assert main(["record", "../first/arm.xml", "--out", "../logs", *few]) == 0
    (arm / "logs").rename(arm / "elsewhere")
    (arm / "first").rename(arm / "gone")
    capsys.readouterr()
    assert main(["check", "../elsewhere/recordings.toml", "--out", "../judged"]) == 0
    assert len(json.loads((arm / "judged" / "check.json").read_text())["recordings"]) == 3


def test_logs_of_a_urdf_need_motors(arm, capsys):
    time = np.arange(50) * 0.01
    angles = {f"qpos.{joint}": np.sin(time) for joint in ("shoulder", "elbow")}
    write_csv(arm / "robot" / "free.csv", {"time": time, **angles})
    write_csv(arm / "robot" / "driven.csv", {"time": time, **angles, "ctrl.elbow": time})
    assert main(["check", "arm.urdf", "free.csv"]) == 0
    assert main(["check", "arm.urdf", "driven.csv"]) == 2
    error = capsys.readouterr().err
    assert "'ctrl.elbow' names nothing" in error and "`estexp check arm.urdf --init` writes an MJCF" in error


def test_the_explained_model_loads_from_anywhere(arm):
    robot = Robot.from_xml("arm.urdf")
    change = parse_change("coulomb_friction@elbow T=0.5", robot)
    text, files = explained_xml(robot, [change], [], 4)
    (arm / "assets").mkdir()
    for name, source in files.items():
        (arm / "assets" / name).write_bytes(source.read_bytes())
    (arm / "model_explained.xml").write_text(text)
    model = mujoco.MjModel.from_xml_path(str(arm / "model_explained.xml"))
    assert model.nmesh == 1 and model.dof_frictionloss.tolist() == [0.0, 0.5]


@pytest.mark.parametrize("command", ["check", "explain", "recover", "record", "bench"])
def test_every_command_refuses_models_that_read_elsewhere(arm, command, capsys):
    (arm / "robot" / "arm.urdf").write_text(urdf("../../secret.stl"))
    write_box(arm / "secret.stl")
    logs = ["a.csv", "b.csv"] if command in ("check", "explain") else []
    model = ["--model", "arm.urdf"] if command == "bench" else ["arm.urdf"]
    assert main([command, *model, *logs, "--out", "../out"]) == 2
    error = capsys.readouterr().err
    assert "leads out of the model's folder" in error and "Traceback" not in error
    assert not (arm / "out").exists()
