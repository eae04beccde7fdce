"""Models of public packages: found in wheels, tried one by one, counted; the study's own download is not tested."""

import json
import zipfile
from pathlib import Path

import pytest

from experiments.robustness.public_models import run
from tests.conftest import ROOT

STUDY = ROOT / "experiments" / "robustness" / "public_models"
PENDULUM = '<mujoco><worldbody><body><joint name="j"/><geom size=".1"/></body></worldbody>{}</mujoco>'
MODELS = {
    "robots/__init__.py": "",
    "robots/arm/arm.xml": PENDULUM.format('<include file="../shared/motor.xml"/>'),
    "robots/shared/motor.xml": '<mujoco><actuator><motor name="m" joint="j"/></actuator></mujoco>',
    "robots/block.xml": "<mujoco/>",
}


def test_models_of_a_wheel_are_tried(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    wheels = tmp_path / "wheels"
    wheels.mkdir()
    with zipfile.ZipFile(wheels / "robots-1.0-py3-none-any.whl", "w") as wheel:
        for name, text in MODELS.items():
            wheel.writestr(name, text)
    arguments = ["--packages", str(wheels), "--out", str(tmp_path / "out")]
    assert run.main(arguments) == 0
    found = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert found["packages"] == {"robots-1.0": {"right": 1, "no joint": 1, "not loaded": 1}}
    assert found["models"] == 1 and found["largest_error"] < 1e-9
    assert "| robots-1.0 | robots/arm/arm.xml | right | 1, 1, 0 |" in (tmp_path / "out" / "models.md").read_text()
    capsys.readouterr()
    assert run.main([*arguments, "--resume"]) == 0 and "arm.xml:" not in capsys.readouterr().out


def test_what_is_published_holds_the_promise() -> None:
    found = json.loads((STUDY / "summary.json").read_text())
    judged = found["models"] - found["results"].get("unstable", 0)
    assert found["results"]["right"] >= 0.97 * judged
    assert not {"wrong", "crashed"} & set(found["results"])
