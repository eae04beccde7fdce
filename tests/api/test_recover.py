"""`recover`: its settings; with `--hardware`, a robot that another thread plays from the controllers' files alone."""

import json
import os
import re
import signal
import threading
import time
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pytest

from estexp_jax.api.options.recover import RecoverOptions
from estexp_jax.api.recover import recover_settings_of
from estexp_jax.cli.main import main
from estexp_jax.errors import InputError
from estexp_jax.package_data import model_path
from tests.conftest import ROOT

SETTLE, STEPS, SUBSTEPS = 20, 60, 4
SIZES = f"--seed 1 --population 8 --generations 2 --steps {STEPS} --settle-steps {SETTLE} --passes 1"
QUICK = ("--paper", "--model-error", "0")
"""An estimation of two generations; what it finds does not matter."""


class Played:
    """The quadruped in MuJoCo with a motor of half the strength, driven by the program of the page on recovering.

    Args:
        exchange: the folder.
        measured: whether somebody adds how far it came, by hand.
    """

    def __init__(self, exchange: Path, *, measured: bool = False) -> None:
        self._exchange, self._measured = exchange, measured
        self._model = mujoco.MjModel.from_xml_path(str(model_path("quadruped")))
        self._data = mujoco.MjData(self._model)
        page = (ROOT / "docs" / "recovering.md").read_text(encoding="utf-8")
        [program] = re.findall(r"^```python\n(import os\n.*?)^```$", page, re.S | re.M)
        self._program = program.replace("exchange/", f"{exchange}/")

    def walk(self, number: int, recording: str = "trial") -> None:
        """Wait for a controller, and leave its recording."""
        awaited(self._exchange / f"controller_{number}.npz")
        share = 1.0 if recording == "healthy" else 0.5
        for table in (self._model.actuator_gainprm, self._model.actuator_biasprm, self._model.actuator_forcerange):
            table[0] = share * table[1]
        self._data = mujoco.MjData(self._model)
        mujoco.mj_resetDataKeyframe(self._model, self._data, 0)
        mujoco.mj_step(self._model, self._data, SUBSTEPS * SETTLE)
        began = float(self._data.qpos[0])
        names = {"controller_0": f"controller_{number}", "trial_0.csv": f"{recording}_{number}.csv"}
        program = self._program
        for name, other in names.items():
            program = program.replace(name, other)
        if self._measured:
            program = program.replace("names = [", "measure(rows)\nnames = ['qpos.root.0', ")
        exec(program, {"read": self._read, "send": self._send, "measure": lambda rows: self._measure(rows, began)})  # noqa: S102

    def _measure(self, rows: list[list[float]], began: float) -> None:
        for row in rows:
            row.insert(0, np.nan)
        rows[0][0], rows[-1][0] = began, float(self._data.qpos[0])

    def _read(self, names: np.ndarray) -> np.ndarray:
        mujoco.mj_forward(self._model, self._data)
        raw = np.array([self._data.sensor(str(name)).data[0] for name in names])
        touch = np.array([str(name).startswith("touch") for name in names])
        return np.where(touch, np.where(raw > 0.0, 1.0, -1.0), raw)

    def _send(self, names: np.ndarray, commands: np.ndarray) -> None:
        for name, command in zip(names, commands, strict=True):
            self._data.actuator(str(name)).ctrl[:] = command
        mujoco.mj_step(self._model, self._data, SUBSTEPS)


def awaited(path: Path) -> None:
    end = time.monotonic() + 900.0
    while not path.exists() and time.monotonic() < end:
        time.sleep(0.02)


def recover(exchange: Path, out: Path, *more: str) -> int:
    return main(["recover", "--hardware", str(exchange), "--out", str(out), *SIZES.split(), *more])


def tried(exchange: Path, out: Path, *more: str) -> int:
    return recover(exchange, out, *QUICK, *more)


def meanwhile(*tasks: Callable[[], object]) -> threading.Thread:
    def run() -> None:
        for task in tasks:
            task()

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    return thread


def with_a_motor_turned(trial: Path) -> None:
    """The recording anew, the first motor's commands with the other sign."""
    header, *rows = [line.split(",") for line in trial.read_text().splitlines()]
    turned = [[row[0], str(-float(row[1])), *row[2:]] for row in rows]
    trial.with_suffix(".part").write_text("\n".join(",".join(cells) for cells in [header, *turned]))
    trial.with_suffix(".part").rename(trial)


def test_what_is_given_goes_over_the_quick_settings() -> None:
    settings = recover_settings_of(RecoverOptions(quick=True, steps=77, seed=4))
    assert (settings.steps, settings.seed, settings.situation) == (77, 4, 3)
    assert settings.population < recover_settings_of(RecoverOptions()).population
    assert recover_settings_of(RecoverOptions(damage=("gravity_tilt angle=0.1",))).situation is None
    with pytest.raises(InputError, match="together"):
        recover_settings_of(RecoverOptions(situation=2, damage=("gravity_tilt angle=0.1",)))


def test_from_a_bad_recording_over_an_interruption_to_the_end(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    exchange, out = tmp_path / "exchange", tmp_path / "out"
    played, trial, asked = Played(exchange), exchange / "trial_0.csv", exchange / "controller_0.npz"

    # At once after it is there, so that it is not read before.
    meanwhile(lambda: played.walk(0), lambda: with_a_motor_turned(trial))
    assert tried(exchange, out) == 2
    told = capsys.readouterr()
    assert f"wanted: {trial}" in told.out
    assert re.search(r"estexp: error: .*trial_0\.csv, column 'ctrl\.hip_f': commands are off by", told.err)

    trial.unlink()
    before = asked.stat().st_mtime_ns

    def interrupt() -> None:
        while asked.stat().st_mtime_ns == before:  # it is written anew just before the waiting
            time.sleep(0.02)
        time.sleep(0.3)
        os.kill(os.getpid(), signal.SIGINT)

    meanwhile(interrupt)
    assert tried(exchange, out, "--resume") == 3
    assert "--resume" in capsys.readouterr().err

    meanwhile(lambda: played.walk(0), lambda: played.walk(1))
    assert tried(exchange, out, "--resume") == 0
    told = capsys.readouterr().out
    assert "the damaged robot walks an unknown distance" in told and "diagnosis 1:" in told
    assert "trial 1 an unknown distance (predicted" in told
    run = json.loads((out / "run.json").read_text())
    assert run["config"]["robot"] == "hardware" and run["planted"] == []
    assert run["distance"] == {"before": None, "damaged": None}
    [only] = run["passes"]
    assert only["hardware_m"] is None and only["simulated_m"] is not None
    page = (out / "report.html").read_text()
    assert "How far the robot walks is not known" in page and "true damage" not in page and "nan m" not in page
    with np.load(out / "traces.npz") as traces:
        assert len(traces["trial_1/angle_f"]) == STEPS

    kept = trial.read_bytes()
    for more in ((), ("--force",)):
        assert tried(exchange, tmp_path / "other", *more) == 2
        assert "recordings of an earlier run" in capsys.readouterr().err
    assert tried(exchange, out, "--force") == 2
    assert (out / "run.json").exists() and trial.read_bytes() == kept


def test_a_robot_that_is_not_damaged_yet_walks_first(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """And with its distance in the recordings, for the metric that wants it."""
    exchange, out = tmp_path / "exchange", tmp_path / "out"
    played = Played(exchange, measured=True)
    meanwhile(lambda: played.walk(0, "healthy"), lambda: played.walk(0), lambda: played.walk(1))
    assert tried(exchange, out, "--healthy", "--metric", "distance") == 0
    told = capsys.readouterr().out
    assert "healthy_0.csv, a recording of the robot before its damage" in told and "is damaged, and walks" in told
    run = json.loads((out / "run.json").read_text())
    assert run["config"]["healthy"] is True
    assert all(isinstance(run["distance"][name], float) for name in ("before", "damaged"))
    assert isinstance(run["passes"][0]["hardware_m"], float)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--situation", "3"), "--situation and --hardware together"),
        (("--damage", "gravity_tilt angle=0.1"), "--damage and --hardware together"),
        (("--robot", "same"), "--robot and --hardware together"),
    ],
)
def test_what_only_a_simulated_robot_does_is_refused(
    arguments: tuple[str, str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert tried(tmp_path / "exchange", tmp_path / "out", *arguments) == 2
    assert message in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_simulated_robot_needs_no_healthy_recording(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["recover", "--healthy"]) == 2
    assert "--hardware" in capsys.readouterr().err


@pytest.mark.slow
def test_its_damage_is_found(tmp_path: Path) -> None:
    exchange, out = tmp_path / "exchange", tmp_path / "out"
    played = Played(exchange)
    meanwhile(lambda: played.walk(0, "healthy"), lambda: played.walk(0), lambda: played.walk(1))
    assert recover(exchange, out, "--healthy") == 0
    [only] = json.loads((out / "run.json").read_text())["passes"]
    [found] = only["diagnosis"]
    assert (found["effect"], found["name"]) == ("motor_weakness", "hip_f")
    assert found["parameters"]["loss"] == pytest.approx(0.5, abs=0.1)
