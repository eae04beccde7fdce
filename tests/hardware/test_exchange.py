"""A robot that is met through files: what is written, what is waited for, what is refused."""

import io
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import estexp_jax as ee
from estexp_jax.errors import InputError
from estexp_jax.hardware.exchange import HardwareTarget, lock_exchange_folder
from estexp_jax.package_data import model_path
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recordings.write import write_csv
from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.control.trial import Controller, Trial
from estexp_jax.runs import ProgressDisplay
from tests.recovery.loops import STEPS, columns_of, controller_of, walked

SETTINGS = Settings(situation=None, steps=STEPS, passes=1)


@pytest.fixture(scope="module")
def robot() -> Robot:
    return Robot.from_xml(model_path("quadruped"))


@pytest.fixture(scope="module")
def controller(robot: Robot) -> Controller:
    return controller_of(robot)


@pytest.fixture(scope="module")
def predicted(controller: Controller) -> Trial:
    return walked(controller, phase=1.3)


@pytest.fixture
def told() -> io.StringIO:
    return io.StringIO()


@pytest.fixture
def hardware(robot: Robot, tmp_path: Path, told: io.StringIO) -> HardwareTarget:
    progress = ProgressDisplay(out=told, err=io.StringIO())
    return HardwareTarget(robot, SETTINGS, tmp_path, progress, poll=0.01, patience=0.2)


@pytest.fixture
def columns(robot: Robot, controller: Controller) -> dict[str, np.ndarray]:
    return columns_of(robot, controller, walked(controller))


def later(do: Callable[[], object], when: Path) -> threading.Thread:
    """Do something as soon as a file is there."""

    def run() -> None:
        while not when.exists():
            time.sleep(0.01)
        do()

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    return thread


def test_a_trial_is_asked_for_and_awaited(
    hardware: HardwareTarget,
    controller: Controller,
    predicted: Trial,
    columns: dict[str, np.ndarray],
    tmp_path: Path,
    told: io.StringIO,
) -> None:
    thread = later(lambda: write_csv(tmp_path / "trial_2.csv", columns), tmp_path / "controller_2.npz")
    trial = hardware.perform(2, controller, predicted)
    thread.join()
    np.testing.assert_allclose(trial.readings, walked(controller).readings, atol=1e-12)
    assert trial.distance("x") == pytest.approx(1.18)
    assert "wanted: " in told.getvalue() and "trial_2.csv" in told.getvalue()
    commands = np.genfromtxt(tmp_path / "commands_2.csv", delimiter=",", names=True, deletechars="")
    assert commands.dtype.names is not None
    assert commands.dtype.names[:2] == ("time", "ctrl.hip_f") and len(commands) == STEPS
    np.testing.assert_allclose(commands["ctrl.hip_f"], predicted.commands[:, 0])
    np.testing.assert_array_equal(ee.load_controller(tmp_path / "controller_2.npz").weights, controller.weights)
    assert not list(tmp_path.glob("*.part"))


def test_a_file_that_is_still_being_written_is_waited_for(
    hardware: HardwareTarget, controller: Controller, predicted: Trial, columns: dict[str, np.ndarray], tmp_path: Path
) -> None:
    write_csv(tmp_path / "whole.csv", columns)
    text = (tmp_path / "whole.csv").read_text()

    def slowly() -> None:
        with (tmp_path / "trial_0.csv").open("w") as stream:
            for start in range(0, len(text), len(text) // 4):
                stream.write(text[start : start + len(text) // 4])
                stream.flush()
                time.sleep(0.06)

    thread = later(slowly, tmp_path / "controller_0.npz")
    trial = hardware.perform(0, controller, predicted)
    thread.join()
    assert len(trial.time) == STEPS


def test_a_bad_file_is_told_and_its_correction_is_read(
    hardware: HardwareTarget, controller: Controller, predicted: Trial, columns: dict[str, np.ndarray], tmp_path: Path
) -> None:
    log = tmp_path / "trial_0.csv"
    write_csv(tmp_path / "good.csv", columns)
    good = (tmp_path / "good.csv").read_text().splitlines()
    bad = [*good[:5], "zero" + good[5][good[5].index(",") :], *good[6:]]
    thread = later(lambda: log.write_text("\n".join(bad)), tmp_path / "controller_0.npz")
    with pytest.raises(InputError, match=r"trial_0\.csv, row 6, column 'time': 'zero' is not a number"):
        hardware.perform(0, controller, predicted)
    thread.join()
    log.write_text("\n".join(good))
    assert hardware.perform(0, controller, predicted).open_loop_readings is None


def test_a_recording_of_another_controller_is_refused(
    robot: Robot,
    hardware: HardwareTarget,
    controller: Controller,
    predicted: Trial,
    columns: dict[str, np.ndarray],
    tmp_path: Path,
) -> None:
    log = tmp_path / "trial_0.csv"
    write_csv(log, columns)
    with pytest.raises(InputError, match=r"trial_0\.csv: is there, and controller_0\.npz of this run is not"):
        hardware.perform(0, controller, predicted)
    log.unlink()
    thread = later(lambda: write_csv(log, columns), tmp_path / "controller_0.npz")
    hardware.perform(0, controller, predicted)
    thread.join()
    with pytest.raises(InputError, match="another run's"):
        hardware.perform(0, controller_of(robot, seed=1), predicted)
    assert log.exists()


def test_the_distance_may_be_unknown_unless_it_is_what_counts(
    robot: Robot,
    hardware: HardwareTarget,
    controller: Controller,
    predicted: Trial,
    columns: dict[str, np.ndarray],
    tmp_path: Path,
    told: io.StringIO,
) -> None:
    less = {name: values for name, values in columns.items() if not name.startswith("qpos.")}
    thread = later(lambda: write_csv(tmp_path / "trial_0.csv", less), tmp_path / "controller_0.npz")
    assert np.isnan(hardware.perform(0, controller, predicted).distance("x"))
    thread.join()
    assert "distance is not known" in told.getvalue()
    settings = Settings(situation=None, steps=STEPS, metric="distance")
    picky = HardwareTarget(robot, settings, tmp_path, ProgressDisplay(told, told), poll=0.01, patience=0.0)
    with pytest.raises(InputError, match="--metric distance"):
        picky.perform(0, controller, predicted)


def test_a_folder_of_another_run_is_refused(tmp_path: Path) -> None:
    folder = tmp_path / "new" / "robot"
    with lock_exchange_folder(folder, fresh=True, force=False):
        (folder / "controller_0.npz").write_bytes(b"ours")
    with pytest.raises(InputError, match=r"controllers of an earlier run: controller_0\.npz; .*--force replaces"):
        lock_exchange_folder(folder, fresh=True, force=False)
    lock_exchange_folder(folder, fresh=False, force=False)
    lock_exchange_folder(folder, fresh=True, force=True)
    assert not (folder / "controller_0.npz").exists()
    (folder / "trial_0.csv").write_text("theirs")
    for force in (False, True):
        with pytest.raises(InputError, match=r"recordings of an earlier run: trial_0\.csv"):
            lock_exchange_folder(folder, fresh=True, force=force)
    assert (folder / "trial_0.csv").read_text() == "theirs"
    with pytest.raises(InputError, match="is a file"):
        lock_exchange_folder(folder / "trial_0.csv", fresh=True, force=False)


def test_what_is_no_controller_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such controller"):
        ee.load_controller(tmp_path / "controller_0.npz")
    (tmp_path / "text.npz").write_text("no archive")
    np.savez(tmp_path / "other.npz", weights=np.zeros(3))
    for name in ("text.npz", "other.npz"):
        with pytest.raises(InputError, match="is no controller"):
            ee.load_controller(tmp_path / name)
