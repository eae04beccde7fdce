"""estexp check: succeeds wherever files can be read, and writes what it found."""

import json

import numpy as np
import pytest
from PIL import Image

from estexp_jax.cli.main import main
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recordings import read_manifest
from estexp_jax.recordings.write import write_csv


def test_a_manifest_is_judged(data, capsys):
    assert main(["check", "recordings.toml", "--out", "out"]) == 0
    shown = capsys.readouterr().out
    assert "a.csv" in shown and "1 (longest 0.51 s)" in shown and "sensor.angle" in shown
    assert "all recordings: ignored columns: temp" in shown and "out/check.json" in shown
    judged = json.loads((data / "out" / "check.json").read_text())
    assert judged["model"] == "arm.xml" and "jax" in judged["versions"]
    assert [(one["file"], one["role"], one["clock"]["gaps"]) for one in judged["recordings"]] == [
        ("a.csv", "train", 0),
        ("b.csv", "test", 1),
    ]
    assert judged["recordings"][0]["joints"]["elbow"]["excited"] is True


def test_the_figure_shows_commands_readings_and_gaps(data):
    assert main(["check", "recordings.toml", "--out", "out"]) == 0
    with Image.open(data / "out" / "check.png") as image:
        red, _, blue, _ = np.moveaxis(np.asarray(image.convert("RGBA"), np.int32), -1, 0)
    assert red.shape[0] > 200 and red.shape[1] > 600
    assert np.count_nonzero(blue - red > 80) > 100, "no command"
    assert np.count_nonzero(red - blue > 30) > 100, "no gap"


def test_a_model_and_logs_with_a_mapping(data, capsys):
    assert main(["check", "arm.xml", "a.csv", "--test", "b.csv", "--map", "ctrl.servo=goal"]) == 0
    assert "│ test " in capsys.readouterr().out
    assert sorted(path.name for path in data.iterdir()) == ["a.csv", "arm.xml", "b.csv", "recordings.toml"]


def test_settings_of_a_recording_count(data):
    (data / "set.toml").write_text(
        (data / "recordings.toml").read_text() + '[recording.set]\n"actuator.servo.ctrlrange" = [-0.5, 0.5]\n'
    )
    assert main(["check", "set.toml", "--out", "out"]) == 0
    first, second = json.loads((data / "out" / "check.json").read_text())["recordings"]
    assert first["commands"]["servo"]["saturated"] < 0.1 < 0.3 < second["commands"]["servo"]["saturated"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "no recordings given"),
        (["arm.xml"], "no recordings given"),
        (["."], "is a folder; the manifest in it, recordings.toml"),
        (["arm.xml", "a.csv"], "no column 'ctrl.servo'"),
        (["recordings.toml", "a.csv"], "stands alone"),
        (["nowhere.toml"], "no such manifest"),
        (["arm.xml", "nowhere.csv"], "no such recording"),
        (["arm.xml", "a.csv", "--map", "ctrl.servo"], "no mapping"),
        (["arm.xml", "a.csv", "--map", "ctrl.servo=goal", "--map", "ctrl.servo=temp"], "mapped twice"),
        (["recordings.toml", "--out", "a.csv"], "is a file"),
        (["recordings.toml", "--out", "."], "not made by estexp"),
        (["recordings.toml", "--init"], "no model and logs"),
        (["arm.xml", "a.csv", "--init"], "exists already"),
    ],
)
def test_wrong_input(data, capsys, arguments, message):
    assert main(["check", *arguments]) == 2
    out, err = capsys.readouterr()
    assert message in err and err.startswith("estexp: error: ") and err.count("\n") == 1 and out == ""


def test_results_are_not_overwritten(data, capsys):
    assert main(["check", "recordings.toml", "--out", "out"]) == 0
    (data / "out" / "check.json").write_text("mine")
    assert main(["check", "recordings.toml", "--out", "out"]) == 2
    told = capsys.readouterr().err
    assert "--force" in told and "--resume" in told and (data / "out" / "check.json").read_text() == "mine"
    assert main(["check", "recordings.toml", "--out", "out", "--force"]) == 0
    assert (data / "out" / "check.json").read_text() != "mine"
    assert main(["check", "recordings.toml", "--out", "out", "--resume"]) == 0
    assert main(["check", "arm.xml", "a.csv", "--map", "ctrl.servo=goal", "--out", "out", "--resume"]) == 2


def test_init_writes_a_manifest_that_reads(data, capsys):
    assert main(["check", "arm.xml", "a.csv", "--test", "b.csv", "--init", "--out", "out"]) == 0
    manifest = read_manifest(data / "out" / "recordings.toml")
    assert manifest.columns["ctrl.servo"].column == "goal"
    assert [(recording.name, recording.role) for recording in manifest.recordings] == [
        ("a.csv", "train"),
        ("b.csv", "test"),
    ]
    assert (data / "out" / "check.json").exists() and "guesses" in capsys.readouterr().out


def test_init_succeeds_where_nothing_can_be_guessed(data, capsys):
    (data / "strange.csv").write_text("clock,x,y\n0,1,2\n1,3,4\n")
    assert main(["check", "arm.xml", "strange.csv", "--init", "--out", "out"]) == 0
    assert "still to be completed" in capsys.readouterr().out
    text = (data / "out" / "recordings.toml").read_text()
    assert '# "ctrl.servo" = "?"' in text and "not used: clock, x, y" in text
    # A manifest is the user's from then on: --force does not take it away.
    assert main(["check", "arm.xml", "strange.csv", "--init", "--out", "out", "--force"]) == 2
    assert (data / "out" / "recordings.toml").read_text() == text


def test_init_keeps_what_is_mapped(data):
    assert main(["check", "arm.xml", "a.csv", "--init", "--out", "out", "--map", "ctrl.servo=temp"]) == 0
    assert read_manifest(data / "out" / "recordings.toml").columns["ctrl.servo"].column == "temp"


@pytest.mark.parametrize("folder", ["so101", "xl330", "double_pendulum"])
def test_init_on_real_recordings(real_data, tmp_path, folder):
    logs = sorted(str(path) for path in (real_data / folder).glob("*.csv"))[:2]
    assert (
        main(["check", str(real_data / folder / "nominal.xml"), *logs, "--init", "--out", str(tmp_path / "out")]) == 0
    )
    judged = json.loads((tmp_path / "out" / "check.json").read_text())["recordings"]
    assert len(judged) == 2 and all(one["rows"] > 1000 for one in judged)
    assert all(joint["excited"] for joint in judged[0]["joints"].values())


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
