"""mujoco.sysid with all the parameters MJCF has for a joint: masses, damping, friction loss, armature, gains.

Its default residual and optimiser (Gauss-Newton on finite differences over rollouts in C), windows of 2 s of the
training recordings, starts estimated as for all baselines, the nominal step. Two of its habits are allowed for, so
that it is at its best: it stamps a reading one step after the state it belongs to, so recorded times are shifted alike;
and its torque sensors show the command that acts from then on, not the one before, so only positions are fitted.
"""

from __future__ import annotations

import contextlib
import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from experiments.benchmark.baselines.logs import Log, Window, nrmse, windows

MOST = 30
"""Most iterations."""


def available() -> bool:
    """Whether mujoco.sysid can be used: it needs what `pip install 'mujoco[sysid]'` brings."""
    from mujoco import sysid

    return hasattr(sysid, "optimize")


def fit(folder: Path, model: mujoco.MjModel, logs: list[Log]) -> tuple[mujoco.MjModel, dict[str, Any]]:
    """Fit a case; gives the fitted model, and what it changed relative to nominal, with its cost in robot steps."""
    from mujoco import sysid

    spec = mujoco.MjSpec.from_file(str(folder / "nominal.xml"))
    parameters = _parameters(spec, model)
    counted = [0]
    sequences = [_sequence(spec, model, log, i) for i, log in enumerate(logs) if log.role == "train"]
    observed = [(s.name, sysid.SignalType.MjSensor) for s in spec.sensors if s.type == mujoco.mjtSensor.mjSENS_JOINTPOS]
    residual = sysid.build_residual_fn(models_sequences=sequences, n_threads=1, enabled_observations=observed)
    length = sum(len(t.control.times) for s in sequences for t in s.measured_rollout)

    def counting(x: np.ndarray, p: Any, **more: Any) -> Any:
        counted[0] += length * (x.shape[1] if x.ndim > 1 else 1)
        return residual(x, p, **more)

    with contextlib.redirect_stdout(io.StringIO()):
        best, _ = sysid.optimize(parameters, counting, optimizer="mujoco", verbose=False, max_iters=MOST)
    nominal, found = parameters.as_nominal_vector(), best.as_vector()
    changes = dict(zip(parameters.keys(), np.round(found - nominal, 4).tolist(), strict=True))
    return sysid.apply_param_modifiers(best, spec), {"changes": changes, "robot_steps": counted[0]}


def _parameters(spec: mujoco.MjSpec, model: mujoco.MjModel) -> Any:
    """Factors of masses and gains (0.3 to 3), and absolute damping, friction loss and armature of every joint."""
    from mujoco import sysid

    found = sysid.ParameterDict()

    def add(name: str, value: float, low: float, high: float, write: Callable[[mujoco.MjSpec, float], None]) -> None:
        def modify(s: mujoco.MjSpec, p: Any) -> None:
            write(s, float(p.value[0]))

        found.add(sysid.Parameter(name, nominal=value, min_value=low, max_value=high, modifier=modify))

    for b in range(1, model.nbody):
        add(f"mass {model.body(b).name}", 1.0, 0.3, 3.0, _mass(spec, model.body(b).name))
    for j in range(model.njnt):
        v, name = int(model.jnt_dofadr[j]), model.joint(j).name
        if int(model.jnt_type[j]) == int(mujoco.mjtJoint.mjJNT_FREE):
            continue
        size = 10.0 * max(float(model.dof_damping[v]), 1e-3)
        for field, value, high in (
            ("damping", float(model.dof_damping[v]), 2.0 * size),
            ("frictionloss", 1e-4, size),
            ("armature", max(float(model.dof_armature[v]), 1e-5), 10.0 * max(float(model.dof_armature[v]), 1e-2)),
        ):
            add(f"{field} {name}", value, 0.0, high, _joint(name, field))
    for a in range(model.nu):
        name = model.actuator(a).name
        add(
            f"gain {name}",
            1.0,
            0.3,
            3.0,
            _gain(name, model.actuator_gainprm[a].copy(), model.actuator_biasprm[a].copy()),
        )
    return found


def _mass(spec: mujoco.MjSpec, body: str) -> Callable[[mujoco.MjSpec, float], None]:
    masses = [float(g.mass) for g in spec.body(body).geoms]

    def write(s: mujoco.MjSpec, factor: float) -> None:
        for geom, mass in zip(s.body(body).geoms, masses, strict=True):
            geom.mass = mass * factor

    return write


def _joint(name: str, field: str) -> Callable[[mujoco.MjSpec, float], None]:
    def write(s: mujoco.MjSpec, value: float) -> None:
        joint = s.joint(name)
        present = getattr(joint, field)
        setattr(joint, field, value if np.isscalar(present) else np.array([value, *np.ravel(present)[1:]]))

    return write


def _gain(name: str, gain: np.ndarray, bias: np.ndarray) -> Callable[[mujoco.MjSpec, float], None]:
    def write(s: mujoco.MjSpec, factor: float) -> None:
        actuator = s.actuator(name)
        actuator.gainprm[:3], actuator.biasprm[:3] = factor * gain[:3], factor * bias[:3]

    return write


def _sequence(spec: mujoco.MjSpec, model: mujoco.MjModel, log: Log, number: int) -> Any:
    from mujoco import sysid

    cut = [w for w in windows(model, log) if np.all(w.enable)]
    step = model.opt.timestep
    starts = [sysid.create_initial_state(model, w.qpos, w.qvel) for w in cut]
    controls = [_held(w, step) for w in cut]
    readings = [sysid.TimeSeries.from_names(w.time[1:] + step, log.sensor[w.rows[1:]], model) for w in cut]
    names = [f"{number}_{i}" for i in range(len(cut))]
    return sysid.ModelSequences("case", spec, names, starts, controls, readings)


def _held(window: Window, step: float) -> Any:
    """The command in force at the middle of each nominal step."""
    from mujoco import sysid

    time = np.arange(int(np.ceil(window.time[-1] / step)) + 1) * step
    row = np.clip(np.searchsorted(window.time, time + 0.5 * step, side="right") - 1, 0, None)
    return sysid.TimeSeries(time, window.control[row])


def run(folder: Path, model: mujoco.MjModel, logs: list[Log]) -> dict[str, Any]:
    """Errors on training and test recordings, what changed, and the cost."""
    fitted, changed = fit(folder, model, logs)
    roles = {role: nrmse(fitted, [log for log in logs if log.role == role]) for role in ("train", "test")}
    return roles | changed
