"""Sparse regression of the residual force, without simulation (SINDy; Brunton, Proctor and Kutz, PNAS 113, 2016).

Positions are smoothed and differentiated (Savitzky-Golay); inverse dynamics of the nominal model gives the force that
each joint would need beyond its motors; sequentially thresholded least squares explains it by a few of some terms.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np
from scipy.signal import savgol_filter

from experiments.benchmark.baselines.logs import Log, nrmse

TERMS: dict[str, Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]] = {
    "1": lambda q, w, tau: np.ones_like(q),
    "sign w": lambda q, w, tau: _sign(w),
    "w": lambda q, w, tau: w,
    "|w| w": lambda q, w, tau: np.abs(w) * w,
    "q": lambda q, w, tau: q,
    "q^3": lambda q, w, tau: q**3,
    "sin q": lambda q, w, tau: np.sin(q),
    "cos q": lambda q, w, tau: np.cos(q),
    "tau": lambda q, w, tau: tau,
    "|tau| sign w": lambda q, w, tau: np.abs(tau) * _sign(w),
}
"""Candidate terms at a joint by their names: of its position, speed and motor force. The constant comes first."""
_KEEP = 0.05
"""Terms that carry less than this share of the residual's deviation are dropped."""


def library(q: np.ndarray, w: np.ndarray, tau: np.ndarray) -> np.ndarray:
    """Values (..., terms) of all terms at a joint, in their order."""
    return np.stack([term(q, w, tau) for term in TERMS.values()], axis=-1)


def _sign(w: np.ndarray) -> np.ndarray:
    return np.tanh(w / 0.02)


def stlsq(terms: np.ndarray, force: np.ndarray, rounds: int = 10) -> np.ndarray:
    """Coefficients (terms,) by sequentially thresholded least squares."""
    size, kept = np.maximum(terms.std(axis=0), 1e-9), np.ones(terms.shape[1], bool)
    size[0] = 1.0
    found = np.zeros(terms.shape[1])
    for _ in range(rounds):
        found[:] = 0.0
        found[kept] = np.linalg.lstsq(terms[:, kept], force, rcond=None)[0]
        still = kept & (np.abs(found) * size > _KEEP * max(float(np.std(force)), 1e-12))
        if (still == kept).all():
            break
        kept = still
    return np.where(kept, found, 0.0)


def regressed(q: np.ndarray, w: np.ndarray, tau: np.ndarray, force: np.ndarray) -> dict[str, float]:
    """Each term's coefficient in the force that a joint lacks; 0 where it is dropped.

    Args:
        q, w, tau, force: (rows,) position, speed, motor force and missing force of a joint.
    """
    return dict(zip(TERMS, stlsq(library(q, w, tau), force).tolist(), strict=True))


def residual_forces(model: mujoco.MjModel, log: Log) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Positions, speeds, motor forces and missing forces (rows, nv) of a fixed-base robot."""
    place = [_sensor_of(model, j) for j in range(model.njnt)]
    rate = (len(log.time) - 1) / log.time[-1]
    even = np.arange(len(log.time)) / rate
    raw = np.stack([np.interp(even, log.time, log.sensor[:, s]) for s in place], axis=1)
    width = max(7, round(0.06 * rate) | 1)
    q, w, a = (np.asarray(savgol_filter(raw, width, 4, deriv=d, delta=1.0 / rate, axis=0)) for d in range(3))
    held = np.clip(np.searchsorted(log.time, even, side="right") - 1, 0, None)
    data, tau, missing = mujoco.MjData(model), np.zeros_like(q), np.zeros_like(q)
    for k in range(len(even)):
        data.qpos[:], data.qvel[:], data.qacc[:] = q[k], w[k], a[k]
        data.ctrl[:] = log.control[held[k]]
        mujoco.mj_inverse(model, data)
        mujoco.mj_fwdActuation(model, data)
        tau[k] = data.qfrc_actuator * log.enable[held[k]].all()
        missing[k] = data.qfrc_inverse - tau[k]
    inner = slice(width, -width)
    return q[inner], w[inner], tau[inner], missing[inner]


def _sensor_of(model: mujoco.MjModel, joint: int) -> int:
    kind = int(mujoco.mjtSensor.mjSENS_JOINTPOS)
    return next(
        s for s in range(model.nsensor) if int(model.sensor_type[s]) == kind and int(model.sensor_objid[s]) == joint
    )


def run(model: mujoco.MjModel, logs: list[Log]) -> dict[str, Any] | None:
    """Errors with the terms found, and the terms; None for a floating base."""
    if model.nq != model.nv or any(int(t) == int(mujoco.mjtJoint.mjJNT_FREE) for t in model.jnt_type):
        return None
    parts = [residual_forces(model, log) for log in logs if log.role == "train"]
    q, w, tau, missing = (np.concatenate(column) for column in zip(*parts, strict=True))
    laws = [regressed(*joint) for joint in zip(q.T, w.T, tau.T, missing.T, strict=True)]
    found = np.array([list(law.values()) for law in laws])

    def push(qpos: np.ndarray, qvel: np.ndarray, motors: np.ndarray) -> np.ndarray:
        return np.sum(library(qpos, qvel, motors) * found, axis=-1)

    terms = {model.joint(v).name: {t: round(c, 5) for t, c in law.items() if c} for v, law in enumerate(laws)}
    errors = {role: nrmse(model, [log for log in logs if log.role == role], push) for role in ("train", "test")}
    return errors | {"terms": terms}
