"""Robots and schemas are found in a checkout and in a wheel."""

import subprocess
import sys

import pytest

from estexp_jax import package_data
from estexp_jax.errors import InputError
from estexp_jax.package_data import model_path, schema_path
from estexp_jax.physics.model.robot import Robot


def test_the_quadruped_comes_with_the_package():
    assert model_path("quadruped") == model_path("quadruped.xml")
    assert Robot.from_xml(model_path("quadruped")).model.nu == 8


def test_an_unknown_model_is_told_with_those_that_exist():
    with pytest.raises(InputError, match="no model 'centipede'.*known are: .*quadruped"):
        model_path("centipede")
    with pytest.raises(InputError):
        model_path("../models/quadruped")
    with pytest.raises(InputError, match="no schema 'nothing'"):
        schema_path("nothing")


def test_what_lies_in_the_package_comes_first(tmp_path, monkeypatch):
    inside, beside = tmp_path / "package" / "models", tmp_path / "models"
    for folder in (inside, beside):
        folder.mkdir(parents=True)
        (folder / "both.xml").touch()
    (beside / "checkout.xml").touch()
    monkeypatch.setattr(package_data, "_MODELS", (inside, beside))
    assert model_path("both") == inside / "both.xml"
    assert model_path("checkout") == beside / "checkout.xml"


def test_it_does_not_matter_where_one_stands(tmp_path, root):
    code = "from estexp_jax.package_data import model_path; print(model_path('quadruped'))"
    command = [sys.executable, "-c", f"import sys; sys.path.insert(0, {str(root)!r}); {code}"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == str(model_path("quadruped"))
