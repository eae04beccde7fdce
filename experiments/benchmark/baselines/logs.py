"""A case as baselines read it: model, recordings, windows with starts estimated from the recordings alone."""

from __future__ import annotations

import csv
import tomllib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

WINDOW = 2.0
"""Length of the windows errors are taken over, s."""


@dataclass(frozen=True)
class Log:
    """A recording.

    Attributes:
        role: train or test.
        time: (rows,) s from its first row.
        control, enable: (rows, actuators) in force from each row on.
        sensor: (rows, sensor values).
        free: (rows, 13) qpos and qvel of a free joint, where there is one.
    """

    role: str
    time: np.ndarray
    control: np.ndarray
    enable: np.ndarray
    sensor: np.ndarray
    free: np.ndarray | None = None


@dataclass(frozen=True)
class Window:
    """A stretch of a recording that a simulation starts anew for.

    Attributes:
        rows: of the recording, from its start (whose reading counts for nothing).
        qpos, qvel: estimated at its first row.
        time: (rows,) s from its first row.
        control, enable: (rows, actuators) in force from each row on.
    """

    rows: np.ndarray
    qpos: np.ndarray
    qvel: np.ndarray
    time: np.ndarray
    control: np.ndarray
    enable: np.ndarray


def read_case(folder: Path) -> tuple[mujoco.MjModel, list[Log]]:
    """The nominal model and the recordings of a case."""
    manifest = tomllib.loads((folder / "recordings.toml").read_text(encoding="utf-8"))
    model = mujoco.MjModel.from_xml_path(str(folder / manifest["model"]))
    return model, [_read(folder / r["file"], r["role"], model) for r in manifest["recording"]]


def _read(path: Path, role: str, model: mujoco.MjModel) -> Log:
    with path.open(encoding="utf-8") as file:
        names = next(csv.reader(file))
        table = dict(zip(names, np.loadtxt(file, delimiter=",", ndmin=2).T, strict=True))
    actuators = [model.actuator(a).name for a in range(model.nu)]
    sensors = [model.sensor(s).name for s in range(model.nsensor)]
    one = np.ones_like(table["time"])
    free = [f"qpos.root.{i}" for i in range(7)] + [f"qvel.root.{i}" for i in range(6)]
    return Log(
        role,
        table["time"] - table["time"][0],
        np.stack([table[f"ctrl.{a}"] for a in actuators], axis=1),
        np.stack([table.get(f"enable.{a}", one) for a in actuators], axis=1),
        np.stack([table[f"sensor.{s}"] for s in sensors], axis=1),
        np.stack([table[n] for n in free], axis=1) if free[0] in table else None,
    )


def windows(model: mujoco.MjModel, log: Log, length: float = WINDOW) -> list[Window]:
    """A recording cut into windows, each with a start estimated from the samples around it."""
    found = []
    begins = np.searchsorted(log.time, np.arange(0.0, log.time[-1] - 0.5 * length, length))
    for a, b in zip(begins, [*begins[1:], len(log.time) - 1], strict=True):
        part, (qpos, qvel) = slice(a, b + 1), start(model, log, int(a))
        found.append(
            Window(np.arange(a, b + 1), qpos, qvel, log.time[part] - log.time[a], log.control[part], log.enable[part])
        )
    return found


def start(model: mujoco.MjModel, log: Log, row: int) -> tuple[np.ndarray, np.ndarray]:
    """The state at a row: a cubic through position readings within 40 ms (or seven rows); motion capture as it is."""
    qpos = np.array(model.key_qpos[0] if model.nkey else model.qpos0)
    qvel = np.zeros(model.nv)
    if log.free is not None:
        qpos[:7], qvel[:6] = log.free[row, :7], log.free[row, 7:]
    near = np.flatnonzero(np.abs(log.time - log.time[row]) <= 0.04)
    if len(near) < 7:
        near = np.arange(max(0, row - 3), min(len(log.time), row + 4))
    t = log.time[near] - log.time[row]
    for s in range(model.nsensor):
        if int(model.sensor_type[s]) == int(mujoco.mjtSensor.mjSENS_JOINTPOS):
            joint = int(model.sensor_objid[s])
            cubic = np.polynomial.Polynomial.fit(t, log.sensor[near, s], 3)
            qpos[model.jnt_qposadr[joint]], qvel[model.jnt_dofadr[joint]] = cubic(0.0), cubic.deriv()(0.0)
    return qpos, qvel


Push = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]
"""Extra generalised force (nv,) from qpos, qvel and the motors' generalised force."""


def simulate(model: mujoco.MjModel, window: Window, push: Push | None = None) -> np.ndarray:
    """Readings (rows - 1, sensor values) of a model over a window; torque sensors show the command before.

    The model runs at its own step, shortened a little so that steps end on the rows.
    """
    data, step = mujoco.MjData(model), model.opt.timestep
    data.qpos[:], data.qvel[:] = window.qpos, window.qvel
    gain, bias = model.actuator_gainprm.copy(), model.actuator_biasprm.copy()
    found = []
    for row, gap in enumerate(np.diff(window.time)):
        on = window.enable[row][:, None]
        model.actuator_gainprm[:], model.actuator_biasprm[:] = gain * on, bias * on
        data.ctrl[:] = window.control[row]
        n = int(np.ceil(gap / step - 1e-6))
        model.opt.timestep = gap / n
        for _ in range(n):
            if push is not None:
                data.qfrc_applied[:] = push(data.qpos, data.qvel, data.qfrc_actuator)
            mujoco.mj_step(model, data)
        mujoco.mj_forward(model, data)
        found.append(data.sensordata.copy())
    model.actuator_gainprm[:], model.actuator_biasprm[:], model.opt.timestep = gain, bias, step
    return np.array(found)


def nrmse(model: mujoco.MjModel, logs: Sequence[Log], push: Push | None = None) -> float:
    """Error of a model over all windows of some recordings: RMSE over range a sensor, then root mean square."""
    parts = []
    for log in logs:
        cut = windows(model, log)
        errors = np.concatenate([simulate(model, w, push) - log.sensor[w.rows[1:]] for w in cut])
        errors = np.nan_to_num(errors, nan=1e3, posinf=1e3, neginf=-1e3)
        parts.append(np.mean(errors**2, axis=0) / np.ptp(log.sensor, axis=0) ** 2)
    return float(np.sqrt(np.mean(parts)))


def floor(logs: Sequence[Log]) -> float:
    """The error noise alone gives, from third differences: of white noise of deviation s they leave sqrt(20) s."""
    parts = []
    for log in logs:
        rough = np.median(np.abs(np.diff(log.sensor, 3, axis=0)), axis=0) / 0.6745 / np.sqrt(20.0)
        parts.append((rough / np.ptp(log.sensor, axis=0)) ** 2)
    return float(np.sqrt(np.mean(parts)))


def gain(found: float, nominal: float, noise: float) -> float | None:
    """Share of the nominal model's error beyond noise that is gone; None where there is none."""
    before = np.sqrt(max(nominal**2 - noise**2, 0.0))
    return None if before == 0.0 else float(1.0 - np.sqrt(max(found**2 - noise**2, 0.0)) / before)
