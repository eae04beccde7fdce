"""What users try from Python: each line works, or is an `InputError` that says what would be right."""

import copy
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pytest

import estexp_jax as ee
from estexp_jax.errors import InputError
from estexp_jax.report.explain.result import ExplainResult
from estexp_jax.report.propose.result import Proposal
from tests.pendulum import PENDULUM
from tests.report import examples

TIME = 0.01 * np.arange(40)
LOG = {"time": TIME, "ctrl.servo": 0.3 * np.sin(5.0 * TIME)}
FULL = {**LOG, "sensor.angle": 0.29 * np.sin(5.0 * TIME - 0.1)}


@pytest.fixture(scope="module")
def here(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("tried")
    (folder / "p.xml").write_text(PENDULUM)
    pd.DataFrame(LOG).to_csv(folder / "log.csv", index=False)
    pd.DataFrame(FULL).to_csv(folder / "full.csv", index=False)
    (folder / "empty.csv").write_text("")
    return folder


MODELS: dict[str, Callable[[], Any]] = {
    "a path as text": lambda: "p.xml",
    "a path": lambda: Path("p.xml"),
    "MJCF text": lambda: PENDULUM,
    "MJCF text after blanks": lambda: f"\n  {PENDULUM}",
    "an MjSpec": lambda: mujoco.MjSpec.from_string(PENDULUM),
    "an MjSpec built by hand": lambda: _built(),
    "an MjModel": lambda: mujoco.MjModel.from_xml_string(PENDULUM),
    "a Robot": lambda: ee.Robot.from_xml("p.xml"),
    "a pickled Robot": lambda: _pickled(ee.Robot.from_xml("p.xml")),
    "a copied Robot": lambda: copy.deepcopy(ee.Robot.from_string(PENDULUM)),
}
LOGS: dict[str, Callable[[], Any]] = {
    "a path as text": lambda: "log.csv",
    "a path": lambda: Path("log.csv"),
    "a glob": lambda: "log*.csv",
    "a list of one": lambda: ["log.csv"],
    "a dict of arrays": lambda: LOG,
    "a dict of lists": lambda: {name: values.tolist() for name, values in LOG.items()},
    "a pandas frame": lambda: pd.DataFrame(LOG),
    "a pandas frame with time as index": lambda: pd.DataFrame(LOG).set_index("time"),
    "a polars frame": lambda: pl.DataFrame(LOG),
    "an Arrow table": lambda: pa.table(LOG),
    "a structured array": lambda: pd.DataFrame(LOG).to_records(index=False).view(np.ndarray),
    "a frame by name": lambda: {"first": pd.DataFrame(LOG)},
    "a generator": lambda: (frame for frame in [pd.DataFrame(LOG)]),
    "numbers of single precision": lambda: {name: values.astype(np.float32) for name, values in LOG.items()},
}
MISUSE: dict[str, tuple[Callable[[], Any], str]] = {
    "no such model": (lambda: ee.simulate("no.xml", LOG), "give the path of a MuJoCo XML"),
    "a number as model": (lambda: ee.simulate(3, LOG), "a path of an MJCF or URDF, MJCF text"),  # pyright: ignore[reportArgumentType]
    "None as model": (lambda: ee.check(None, "full.csv"), "a path of an MJCF or URDF, MJCF text"),  # pyright: ignore[reportArgumentType]
    "MJCF text with a mistake": (lambda: ee.check("<mujoco><oops/></mujoco>", "full.csv"), "does not compile"),
    "a model that MuJoCo forgot": (lambda: ee.check(_forgotten(), "full.csv"), "give the path that it came from"),
    "no recordings": (lambda: ee.explain("p.xml"), "at least one log"),
    "an empty list": (lambda: ee.explain("p.xml", []), "at least one log"),
    "no such log": (lambda: ee.explain("p.xml", "no.csv"), "no.csv"),
    "a glob that fits nothing": (lambda: ee.explain("p.xml", "no*.csv"), "a glob such as logs/"),
    "a number as log": (lambda: ee.explain("p.xml", 5), "a data frame"),  # pyright: ignore[reportArgumentType]
    "a plain array": (lambda: ee.explain("p.xml", np.zeros((9, 3))), "a data frame"),
    "an empty file": (lambda: ee.check("p.xml", "empty.csv"), "empty.csv"),
    "an empty frame": (lambda: ee.check("p.xml", pd.DataFrame()), "frame_0"),
    "a log of its text": (lambda: ee.check("p.xml", "time,ctrl.servo\n" * 400), "time,ctrl.servo"),
    "columns of other names": (lambda: ee.check("p.xml", pd.DataFrame({"t": TIME, "u": TIME})), "time"),
    "columns of unequal length": (lambda: ee.check("p.xml", {**FULL, "sensor.angle": TIME[:9]}), "sensor.angle"),
    "text where numbers belong": (lambda: ee.check("p.xml", {**FULL, "sensor.angle": ["a"] * 40}), "sensor.angle"),
    "a folder": (lambda: ee.check("p.xml", "."), "a manifest, or a model and its logs"),
    "a wrong keyword": (lambda: ee.explain("p.xml", "full.csv", windw=2.0), "known are: window"),  # pyright: ignore[reportCallIssue]
    "a number out of range": (lambda: ee.explain("p.xml", "full.csv", most=-1), "most"),
    "an unknown effect": (lambda: ee.explain("p.xml", "full.csv", effects=["frictoin"]), "known are"),
    "an unknown engine": (lambda: ee.simulate("p.xml", LOG, engine="gpu"), "engine"),
    "a start of wrong size": (lambda: ee.simulate("p.xml", LOG, start={"qpos": [1.0, 2.0]}), "qpos"),
    "an effect that is nowhere": (lambda: ee.record("p.xml", "out", effect="backlash@knee half_gap=1"), "elbow"),
    "a result that is not there": (lambda: ee.load_explained("nothing"), "nothing"),
    "propose without explain": (lambda: ee.propose("."), "explain"),
    "a class that is no effect": (lambda: ee.register(int), "effect"),  # pyright: ignore[reportArgumentType]
    "a sensor that is not there": (lambda: _explained().plot_fit(reading="knee"), "known are: angle, force.0"),
    "a recording that is not there": (lambda: _explained().plot_fit(recording="c.csv"), "known are: a.csv"),
    "axes that are none": (lambda: _explained().plot_fit(ax=3), "axes from plt.subplots"),
}


def _pickled(one: Any) -> Any:
    return pickle.loads(pickle.dumps(one))  # noqa: S301 (what was just pickled here)


def _built() -> mujoco.MjSpec:
    spec = mujoco.MjSpec()
    body = spec.worldbody.add_body(name="arm", pos=[0.0, 0.0, 1.0])
    body.add_joint(name="elbow", axis=[0.0, 1.0, 0.0], damping=[0.02, 0.0, 0.0])
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_CAPSULE, fromto=[0.0, 0.0, 0.0, 0.0, 0.0, -0.3], size=[0.02, 0, 0], mass=0.5
    )
    servo = spec.add_actuator(name="servo", target="elbow", trntype=mujoco.mjtTrn.mjTRN_JOINT)
    servo.set_to_position(8.0)
    spec.add_sensor(
        name="angle", type=mujoco.mjtSensor.mjSENS_JOINTPOS, objtype=mujoco.mjtObj.mjOBJ_JOINT, objname="elbow"
    )
    return spec


def _forgotten() -> mujoco.MjModel:
    model = mujoco.MjModel.from_xml_string(PENDULUM)
    mujoco.MjModel.from_xml_string("<mujoco/>")
    return model


def _explained() -> ExplainResult:
    return ExplainResult(examples.diagnosis(), examples.FINDINGS)


@pytest.mark.parametrize("model", MODELS)
def test_models(model: str, here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(here)
    found = ee.simulate(MODELS[model](), LOG)
    assert 0.05 < np.abs(found["sensor.angle"]).max() < 1.0


@pytest.mark.parametrize("log", LOGS)
def test_logs(log: str, here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(here)
    found, wanted = ee.simulate("p.xml", LOGS[log]()), ee.simulate("p.xml", LOG)
    np.testing.assert_allclose(
        found["sensor.angle"], wanted["sensor.angle"], atol=2e-3
    )  # times of single precision fall into other steps


@pytest.mark.parametrize("what", MISUSE)
def test_misuse_is_told_with_a_remedy(what: str, here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(here)
    tried, remedy = MISUSE[what]
    with pytest.raises(InputError) as refused:
        tried()
    assert remedy in str(refused.value)


def _same(result: Any) -> tuple[Any, ...]:
    return _pickled(result), copy.deepcopy(result), copy.copy(result)


def test_results_pickle_copy_and_print_well(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(here)
    explained, proposed = _explained(), Proposal(examples.proposal())
    for result in (explained, proposed):
        assert len(repr(result)) < 3000 and "object at 0x" not in repr(result)
        for other in _same(result):
            assert repr(other) == repr(result)
    for other in _same(explained):
        assert (other.verdict, other.what, other.where, other.fit) == (
            explained.verdict,
            explained.what,
            explained.where,
            explained.fit,
        )
        assert other.simulator.spec.compile().nq == 1
    assert str(explained.what[0].parameters["T"]) == "1.02 (0.97 to 1.08) N m"
    assert [p.recording for p in explained.predictions()] == [p.recording for p in explained.diagnosis.predictions]
    assert repr(ee.Robot.from_xml("p.xml")) == "Robot(source='p.xml')"
    assert repr(ee.effects()) == repr(copy.copy(ee.effects()))


def test_figures_stand_in_axes_of_the_callers_own() -> None:
    from matplotlib.figure import Figure

    figure, explained = Figure(figsize=(10.0, 5.0), layout="constrained"), _explained()
    left, right = figure.subplots(1, 2)
    pictures = [explained.plot_fit(ax=left), explained.plot_where(right)]
    assert all(picture.figure is figure for picture in pictures) and len(figure.subfigs) == 2
    assert pictures[0]._repr_png_().startswith(b"\x89PNG")
    assert explained.plot_fit().figure is not figure
    own = explained.plot_fit(reading="force.0", recording="a.csv").figure
    assert own.axes[0].get_ylabel() == "force.0" and own.axes[0].get_title(loc="left") == "a.csv, fitted"


def test_the_table_has_forty_lines_and_more() -> None:
    assert len(MODELS) + len(LOGS) + len(MISUSE) >= 50


def _judged(robot: Any, frame: pd.DataFrame) -> Any:
    return ee.check(robot, frame)


@pytest.mark.slow
def test_ten_logs_in_processes_of_their_own(here: Path) -> None:
    """As joblib does it: function, arguments and results are pickled."""
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import get_context

    robot = ee.Robot.from_xml(here / "p.xml")
    frames = [pd.DataFrame({**FULL, "sensor.angle": FULL["sensor.angle"] * (1.0 + 0.01 * k)}) for k in range(10)]
    with ProcessPoolExecutor(2, get_context("spawn")) as pool:
        found = list(pool.map(_judged, [robot] * 10, frames))
    assert [result.inputs.recordings[0].name for result in found] == ["frame_0"] * 10
    assert all(result.summary() for result in found)


@pytest.mark.slow
def test_a_run_is_continued_after_it_was_pickled(root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(root)
    sizes: dict[str, Any] = {"passes": 1, "population": 8, "generations": 1, "steps": 30, "settle_steps": 5}
    run = ee.recover("models/quadruped.xml", seed=1, **sizes)
    with pytest.raises(InputError, match="first iterate over the run"):
        run.write(tmp_path / "out")
    other = _pickled(run).finish()
    assert repr(other) == repr(run.finish()) and "pass" in repr(other)
    assert other.write(tmp_path / "out", pictures=False).is_file()
    assert repr(_pickled(other)) == repr(other)
