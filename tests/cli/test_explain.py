"""`estexp record`, `estexp explain` and `load_explained`: from a concealed effect to its simulator."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import jsonschema
import mujoco
import numpy as np
import pytest

import estexp_jax as ee
from estexp_jax.cli.main import main
from estexp_jax.package_data import schema_path
from estexp_jax.recordings.readers.read import read_table
from tests.pendulum import PENDULUM, SMALL, run


def test_a_recording_holds_what_was_promised(recorded):
    written = {path.name for path in recorded.iterdir()}
    promised = {"nominal.xml", "train_0.csv", "train_1.csv", "test_0.csv", "recordings.toml", "truth.json"}
    assert promised <= written
    truth = json.loads((recorded / "truth.json").read_text())
    assert truth["effects"] == [
        {"effect": "coulomb_friction", "kind": "joint", "name": "elbow", "parameters": {"T": 0.35}}
    ]
    assert read_table(recorded / "train_0.csv").names == ("time", "ctrl.servo", "sensor.angle")


def test_the_concealed_friction_is_named_with_its_size(explained):
    findings = json.loads((explained / "findings.json").read_text())
    jsonschema.validate(findings, json.loads(schema_path("findings").read_text()))
    assert findings["verdict"] == "missing_physics"
    [found] = findings["what"]
    assert (found["effect"], found["name"]) == ("coulomb_friction", "elbow")
    assert found["parameters"]["T"]["value"] == pytest.approx(0.35, rel=0.05)
    assert findings["where"][0]["name"] == "elbow"
    assert findings["fit"]["gain"]["value"] > 0.9


def test_predictions_stand_beside_what_was_recorded(explained, recorded):
    for name in ("train_0", "train_1", "test_0"):
        table = read_table(explained / "predictions" / f"{name}.csv")
        assert table.names == ("time", "window", "angle.recorded", "angle.nominal", "angle.explained")
        log = read_table(recorded / f"{name}.csv")
        np.testing.assert_array_equal(table.column("time"), log.column("time"))
        np.testing.assert_array_equal(table.column("angle.recorded"), log.column("sensor.angle"))
        np.testing.assert_array_equal(np.unique(table.column("window")), [0, 1, 2, 3])
        error = {m: table.column(f"angle.{m}") - table.column("angle.recorded") for m in ("nominal", "explained")}
        assert np.std(error["explained"]) < 0.3 * np.std(error["nominal"])


def test_the_explained_model_loads_and_holds_the_friction(explained):
    model = mujoco.MjModel.from_xml_path(str(explained / "model_explained.xml"))
    found = json.loads((explained / "findings.json").read_text())["what"][0]["parameters"]["T"]["value"]
    assert model.dof_frictionloss[0] == pytest.approx(found, rel=1e-12)
    assert model.opt.timestep == 0.005, "the user's"
    assert json.loads((explained / "effects.json").read_text())["finer"] in (4, 8, 16)


def test_the_simulator_comes_back(explained, recorded):
    simulator = ee.load_explained(explained)
    log = read_table(recorded / "test_0.csv")
    traces = simulator.rollout(log.column("ctrl.servo")[:, None], period=0.01)
    assert traces.sensors.shape == (400, 1)
    assert np.sqrt(np.mean((traces.sensors[:, 0] - log.column("sensor.angle")) ** 2)) < 0.01


def test_the_report_needs_no_network(explained):
    page = (explained / "report.html").read_text()
    assert "coulomb" in page.lower() and "elbow" in page
    assert 'src="http' not in page and "<script src" not in page and '<link rel="stylesheet"' not in page


def test_results_are_not_overwritten_unasked(explained, recorded, capsys):
    before = (explained / "findings.json").read_bytes()
    assert run("explain", recorded / "recordings.toml", "--out", explained, *SMALL) == 2
    assert "--force" in capsys.readouterr().err
    assert (explained / "findings.json").read_bytes() == before


def test_killed_and_resumed_it_finds_the_same(explained, recorded, tmp_path):
    out = tmp_path / "killed"
    command = [sys.executable, "-m", "estexp_jax.cli.main", "explain", str(recorded / "recordings.toml")]
    process = subprocess.Popen([*command, "--out", str(out), *SMALL], stdout=subprocess.DEVNULL)
    while not (out / "checkpoint.npz.previous").exists():
        assert process.poll() is None
        time.sleep(0.02)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    assert not (out / "findings.json").exists()
    assert run("explain", recorded / "recordings.toml", "--out", out, *SMALL, "--resume") == 0
    one, other = (json.loads((folder / "findings.json").read_text()) for folder in (explained, out))
    assert {key for key in one if one[key] != other[key]} <= {"cost"}
    written = [path.relative_to(out) for pattern in ("*.csv", "*.xml", "*.json") for path in out.rglob(pattern)]
    same = [name for name in written if name.name not in ("findings.json", ".estexp-run.json")]
    assert len(same) >= 6
    for name in same:
        assert (out / name).read_bytes() == (explained / name).read_bytes(), name


def _broken(name: str, recorded, tmp_path) -> tuple[str, ...]:
    """The command on a copy of the first log, changed."""
    lines = (recorded / "train_0.csv").read_text().splitlines()
    edits = {
        "column": lambda: [",".join(c for c in line.split(",")[::2]) for line in lines],
        "clock": lambda: [*lines[:5], lines[3], *lines[5:]],
        "actuator": lambda: [lines[0].replace("ctrl.servo", "ctrl.servo,ctrl.motor"), *(f"0,{x}" for x in lines[1:])],
        "text": lambda: [*lines[:5], lines[5].rpartition(",")[0] + ",oops", *lines[6:]],
    }
    model = recorded / "nominal.xml"
    if name == "model":
        model = tmp_path / "broken.xml"
        model.write_text(PENDULUM.replace('joint="elbow"', 'joint="shoulder"'))
    log = tmp_path / "log.csv"
    log.write_text("\n".join(edits[name]() if name in edits else lines) + "\n")
    return "explain", str(model), str(log), "--out", str(tmp_path / "out")


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("column", ("log.csv", "ctrl.servo")),
        ("clock", ("log.csv", "row 6", "time")),
        ("actuator", ("log.csv", "ctrl.motor", "servo")),
        ("text", ("log.csv", "row 6", "sensor.angle", "oops")),
        ("model", ("broken.xml", "shoulder")),
    ],
)
def test_wrong_input_is_told_with_file_and_place(name, told, recorded, tmp_path, capsys):
    assert main(list(_broken(name, recorded, tmp_path))) == 2
    error = capsys.readouterr().err.strip()
    assert error.startswith("estexp: error: ") and "\n" not in error and "Traceback" not in error
    for words in told:
        assert words in error
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("--window", "long"), "long"),
        (("--window", "-1"), "-1"),
        (("--most", "0"), "--most"),
        (("--effects", "magic"), "magic"),
    ],
)
def test_wrong_options_are_told(arguments, told, recorded, tmp_path, capsys):
    assert run("explain", recorded / "recordings.toml", "--out", tmp_path / "out", *arguments) == 2
    assert told in capsys.readouterr().err


@pytest.mark.parametrize("effect", ["magic@elbow T=1", "coulomb_friction@knee T=1", "coulomb_friction@elbow K=1"])
def test_an_effect_that_cannot_be_planted_is_told(effect, recorded, tmp_path, capsys):
    assert run("record", recorded / "nominal.xml", "--effect", effect, "--out", tmp_path / "out") == 2
    assert "known are" in capsys.readouterr().err


def test_a_robot_that_flies_apart_is_told_and_nothing_is_logged(tmp_path, capfd, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("arm.xml").write_text(
        """<mujoco><option timestep=".02"/><worldbody><body><joint name="elbow" axis="0 1 0"/>
        <geom size=".1" pos=".3 0 0"/></body></worldbody>
        <actuator><position joint="elbow" kp="1e9"/></actuator></mujoco>"""
    )
    assert run("record", "arm.xml", "--out", "logs", "--duration", "1") == 2
    told = capfd.readouterr().err
    assert "train_0.csv: the simulation diverges after" in told and "WARNING" not in told
    assert not Path("MUJOCO_LOG.TXT").exists() and not Path("logs/train_0.csv").exists()
