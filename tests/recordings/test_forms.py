"""The same log as CSV, NPZ, Parquet, LeRobot data set and MCAP is the same recording."""

import json

import numpy as np
import pytest

from estexp_jax.cli.main import main
from estexp_jax.recordings import read_manifest
from tests.pendulum import PENDULUM
from tests.recordings.readers.forms import FORMS, write_form


def _log(seed, rows=400):
    """A servo's log with cells left empty in both columns; numbers that single precision holds to 1e-6."""
    random = np.random.default_rng(seed)
    time = np.round(np.arange(rows) * 0.01 + 0.002 * random.random(rows), 6)
    time -= time[0]
    goal, position = np.sin(3 * time + seed), np.round(np.sin(3 * (time - 0.03) + seed), 4)
    goal[1:][random.random(rows - 1) < 0.3] = np.nan
    position[random.random(rows) < 0.1] = np.nan
    position[np.isnan(goal) & np.isnan(position)] = 0.25  # MCAP has no rows without a message
    return time, goal, position


def _needs(form):
    if form == "mcap":
        pytest.importorskip("mcap_ros2", reason="MCAP needs the extra `mcap`: pip install 'estexp_jax[mcap]'")


@pytest.fixture(scope="module")
def manifests(tmp_path_factory):
    """The manifest of each form."""
    folder = tmp_path_factory.mktemp("forms")
    (folder / "arm.xml").write_text(PENDULUM)
    logs = [_log(seed) for seed in range(3)]
    written = {}
    for form in FORMS:
        try:
            written[form] = write_form(form, folder / form, logs, folder / "arm.xml")
        except ImportError:
            assert form == "mcap"
    return written


@pytest.mark.parametrize("form", FORMS[1:])
def test_every_form_gives_the_same_table(manifests, form):
    _needs(form)
    first, other = (read_manifest(manifests[name]).recordings for name in ("csv", form))
    assert len(first) == len(other) == 3
    for one, two in zip(first, other, strict=True):
        for name in ("time", "ctrl", "enable", "sensor", "qpos", "qvel"):
            np.testing.assert_allclose(getattr(two, name), getattr(one, name), rtol=0, atol=1e-6, err_msg=name)
        assert one.role == two.role


@pytest.mark.parametrize("form", FORMS[1:])
def test_every_form_is_judged_alike(manifests, form, tmp_path):
    _needs(form)
    checks = {}
    for name in ("csv", form):
        assert main(["check", str(manifests[name]), "--out", str(tmp_path / name)]) == 0
        checks[name] = json.loads((tmp_path / name / "check.json").read_text())
    assert checks["csv"]["advice"] == checks[form]["advice"]
    for one, two in zip(checks["csv"]["recordings"], checks[form]["recordings"], strict=True):
        for judged in (one, two):
            del judged["file"], judged["notes"]
        assert [(f["kind"], f["name"]) for f in one.pop("faults")] == [
            (f["kind"], f["name"]) for f in two.pop("faults")
        ]
        del one["suspicions"], two["suspicions"]
        _same(one, two)


def _same(one, two):
    if isinstance(one, dict):
        assert one.keys() == two.keys()
        for key, value in one.items():
            _same(value, two[key])
    elif isinstance(one, float) and isinstance(two, float):
        assert two == pytest.approx(one, rel=2e-3, abs=2e-6)
    else:
        assert one == two


@pytest.mark.slow
def test_every_form_is_explained_alike(tmp_path):
    (tmp_path / "pendulum.xml").write_text(PENDULUM)
    sizes = ("--duration", "4", "--rate", "100", "--seed", "31")
    effect = ("--effect", "coulomb_friction@elbow T=0.35")
    assert main(["record", str(tmp_path / "pendulum.xml"), *effect, "--out", str(tmp_path / "logs"), *sizes]) == 0
    recorded = read_manifest(tmp_path / "logs" / "recordings.toml").recordings
    logs = [(np.round(r.time - r.time[0], 9), r.ctrl[:, 0], r.sensor[:, 0]) for r in recorded]
    logs = [(log[0], *(values.astype(np.float32).astype(float) for values in log[1:])) for log in logs]
    roles = tuple(recording.role for recording in recorded)
    findings = {}
    for form in FORMS:
        _needs(form)
        manifest = write_form(form, tmp_path / form, logs, tmp_path / "logs" / "nominal.xml", roles)
        out = tmp_path / f"out_{form}"
        few = ("--most", "1", "--effects", "coulomb_friction", "viscous_friction", "command_delay", "--window", "1")
        assert main(["explain", str(manifest), "--out", str(out), *few]) == 0
        findings[form] = json.loads((out / "findings.json").read_text())
    for results in findings.values():
        assert results["verdict"] == "missing_physics"
        assert [(f["effect"], f["name"]) for f in results["what"]] == [("coulomb_friction", "elbow")]
        size = results["what"][0]["parameters"]["T"]["value"]
        assert size == pytest.approx(findings["csv"]["what"][0]["parameters"]["T"]["value"], rel=2e-3)
        assert results["fit"]["gain"]["value"] == pytest.approx(findings["csv"]["fit"]["gain"]["value"], abs=1e-3)
