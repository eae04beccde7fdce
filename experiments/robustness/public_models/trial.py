"""One model: a second of exciting commands through `ee.simulate` and through plain MuJoCo."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

WINDOWS, WINDOW_S, PERIOD_S, HELD_S = 4, 0.25, 0.01, 0.05
RIGHT = 1e-4
"""Largest error of a value that counts as right, as a share of its range in the motion."""
_KINDS = ("sensor", "qpos", "qvel")
Traces = dict[str, np.ndarray]


def tried(path: Path, engine: str) -> dict[str, Any]:
    """What becomes of a model: not loaded or given up by plain MuJoCo, without joints, right, chaotic, refused, wrong.

    Right where every value stays within `RIGHT` of its range in all windows; chaotic where contacts carry a motion
    apart and its first steps are right.
    """
    try:
        with np.errstate(all="ignore"):
            model = mujoco.MjModel.from_xml_path(str(path))
    except ValueError as error:
        return {"result": "not loaded", "message": " ".join(str(error).split())[:200]}
    if model.njnt == 0:
        return {"result": "no joint"}
    from estexp_jax.api.simulate import simulate
    from estexp_jax.errors import InputError

    steps = max(1, round(PERIOD_S / model.opt.timestep))
    rows = max(2, round(WINDOW_S / (steps * model.opt.timestep)) + 1)
    ctrl = exciting(model, rows * WINDOWS, steps)
    (qpos, qvel), scale = motion(model, ctrl, steps)
    found = {"nv": model.nv, "nu": model.nu, "sensors": model.nsensor, "worst": 0.0, "worst_value": ""}
    found |= {"rows": int(np.isfinite(qvel).all(axis=1).sum()), "of": len(qvel), "result": "right"}
    if found["rows"] < 2:
        return found | {"result": "unstable"}
    for w in range(WINDOWS):
        own, start = ctrl[w * rows : (w + 1) * rows], (qpos[w * rows], qvel[w * rows])
        if not np.isfinite(start[0]).all():
            break
        expected, in_contact = plain(model, own, steps, start)
        table = {"time": steps * model.opt.timestep * np.arange(rows)} | columns(model, own)
        begin = time.perf_counter()
        try:
            traces = simulate(path, table, start=start, engine=engine)
        except InputError as error:
            return found | {"result": "refused", "message": str(error)[:300]}
        found.setdefault("first_s", round(time.perf_counter() - begin, 2))
        worst, value = apart(traces, expected, scale, rows)
        if worst > RIGHT and in_contact:
            found["result"] = "chaotic"
            worst, value = apart(traces, expected, scale, 2)
        if worst > found["worst"]:
            found |= {"worst": worst, "worst_value": value}
    return found | ({"result": "wrong"} if found["worst"] > RIGHT else {})


def exciting(model: mujoco.MjModel, rows: int, steps: int) -> np.ndarray:
    """Random commands (rows, nu), held for a while, over the whole range of each input, or from -1 to 1."""
    rng, held = np.random.default_rng(0), max(1, round(HELD_S / (steps * model.opt.timestep)))
    limited = model.actuator_ctrllimited.astype(bool)[:, None]
    low, high = np.where(limited, model.actuator_ctrlrange, [-1.0, 1.0]).T
    return np.repeat(rng.uniform(low, high, (rows // held + 1, model.nu)), held, axis=0)[:rows]


def motion(model: mujoco.MjModel, ctrl: np.ndarray, steps: int) -> tuple[tuple[np.ndarray, np.ndarray], Traces]:
    """States (rows, nq), (rows, nv) of the whole motion, and the ranges of readings, positions and speeds in it."""
    data, kept = mujoco.MjData(model), ([], [], [])
    for row in ctrl:
        for values, x in zip(kept, (data.qpos, data.qvel, data.sensordata), strict=True):
            values.append(np.full_like(x, np.nan) if blown_up(data) else x.copy())
        data.ctrl[:] = row
        for _ in range(steps):
            mujoco.mj_step(model, data)
    qpos, qvel, sensor = map(np.array, kept)
    return (qpos, qvel), {
        kind: np.nanmax(x, axis=0) - np.nanmin(x, axis=0) for kind, x in zip(_KINDS, (sensor, qpos, qvel), strict=True)
    }


def plain(
    model: mujoco.MjModel, ctrl: np.ndarray, steps: int, start: tuple[np.ndarray, np.ndarray]
) -> tuple[Traces, bool]:
    """Readings, positions and speeds (rows, n) of a loop over `mj_step` from a state, and whether parts touched."""
    data, kept, touched = mujoco.MjData(model), {kind: [] for kind in _KINDS}, False
    data.qpos[:], data.qvel[:] = start
    seen = mujoco.MjData(model)
    for row in ctrl:
        mujoco.mj_copyData(seen, model, data)
        mujoco.mj_forward(model, seen)
        for kind, x in zip(_KINDS, (seen.sensordata, data.qpos, data.qvel), strict=True):
            kept[kind].append(np.full_like(x, np.nan) if blown_up(data) else x.copy())
        data.ctrl[:] = row
        for _ in range(steps):
            mujoco.mj_step(model, data)
            touched |= data.ncon > 0
    return {kind: np.array(values) for kind, values in kept.items()}, touched


def blown_up(data: mujoco.MjData) -> bool:
    """Whether MuJoCo itself gave a motion up: from then on there is nothing to compare with."""
    kinds = (mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL, mujoco.mjtWarning.mjWARN_BADQACC)
    return any(data.warning[int(kind)].number for kind in kinds)


def columns(model: mujoco.MjModel, ctrl: np.ndarray) -> Traces:
    """The columns of a log of commands, by the names that the manual gives."""
    found = {}
    for a in range(model.nactuator):
        name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_ACTUATOR, a) or f"actuator_{a}"
        first, n = int(model.actuator_ctrladr[a]), int(model.actuator_ctrlnum[a])
        found |= {f"ctrl.{name}" + (f".{k}" if n > 1 else ""): ctrl[:, first + k] for k in range(n)}
    return found


def apart(traces: Traces, expected: Traces, scale: Traces, rows: int) -> tuple[float, str]:
    """Largest difference in some rows, as a share of the value's range, and of which value."""
    worst, value = 0.0, ""
    for kind in _KINDS:
        names = [name for name in traces if name.startswith(f"{kind}.")]
        if len(names) != expected[kind].shape[1]:
            return float("inf"), f"{len(names)} columns of {kind}"
        for k, name in enumerate(names):
            wanted = expected[kind][:rows, k]
            size = max(float(scale[kind][k]), float(np.nanmax(np.abs(wanted))) * 1e-3, 1e-6)
            off = np.abs(traces[name][:rows] - wanted)[np.isfinite(wanted)] / size
            off = np.where(np.isfinite(off), off, np.inf)
            if off.size and off.max() > worst:
                worst, value = float(off.max()), name
    return worst, value
