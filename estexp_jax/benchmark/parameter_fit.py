"""What a fit of the model's own values answers: `mujoco.sysid` on the recordings that `explain` was given.

Free are the values that one would choose: each joint's damping and armature, each motor's gain. Whole recordings from
their first row on, at home and at rest; its own residual and optimiser.
"""

from __future__ import annotations

import contextlib
import io
import logging
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

import mujoco
import numpy as np

from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.recordings.manifest import read_manifest

_MOST_ITERATIONS = 30
_GAINS = (0.3, 3.0)
"""Range of a factor on a motor's gain."""
_TIMES = 50.0
"""Range of a damping or armature, in times of what the model has."""
_LEAST = {"dof_damping": 1e-3, "dof_armature": 1e-5}
"""Fields that are free, and what counts as the model's own value where it has none, N m s/rad and kg m2."""


@final
@dataclass(frozen=True)
class FittedValue:
    """A value of the model.

    Attributes:
        name: such as `damping of knee`.
        before, after: as the model has it, and as fitted.
    """

    name: str
    before: float
    after: float


@final
@dataclass(frozen=True)
class ParameterFit:
    """What was fitted, and the error on test recordings, as a share of the sensors' range, before and after."""

    values: tuple[FittedValue, ...]
    before: float
    after: float


def sysid_version() -> str | None:
    """The version of MuJoCo whose `mujoco.sysid` can be used; None: `pip install 'mujoco[sysid]'` would bring it."""
    try:
        from mujoco import sysid
    except ImportError:
        return None
    return mujoco.__version__ if hasattr(sysid, "optimize") else None


def fit_parameters(manifest: Path) -> ParameterFit:
    """Fit the training recordings of a manifest whose joints are hinges and slides, measured at each.

    Raises:
        InputError: the manifest cannot be read.
    """
    from mujoco import sysid

    read = read_manifest(manifest)
    robot, spec = read.robot, read.robot.spec.copy()
    train, test = ([r for r in read.recordings if r.role == role] for role in ("train", "test"))
    parameters = sysid.ParameterDict()
    for name, value, low, high, write in _free(robot):
        parameters.add(sysid.Parameter(name, nominal=value, min_value=low, max_value=high, modifier=write))
    residual = sysid.build_residual_fn(models_sequences=[_sequence(spec, robot, r) for r in train], n_threads=1)
    with contextlib.redirect_stdout(io.StringIO()), _quiet("absl"):
        best, _ = sysid.optimize(parameters, residual, optimizer="mujoco", verbose=False, max_iters=_MOST_ITERATIONS)
    fitted = sysid.apply_param_modifiers(best, spec)
    names, before, after = parameters.keys(), parameters.as_nominal_vector(), best.as_vector()
    values = [FittedValue(n, float(b), float(a)) for n, b, a in zip(names, before, after, strict=True)]
    return ParameterFit(tuple(values), _error(robot.model, test), _error(fitted, test))


@contextlib.contextmanager
def _quiet(name: str) -> Iterator[None]:
    logger = logging.getLogger(name)
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        yield
    finally:
        logger.setLevel(level)


Writer = Callable[[mujoco.MjSpec, Any], None]


def _free(robot: Robot) -> Iterator[tuple[str, float, float, float, Writer]]:
    """Name, value in the model, range, and what writes it into a description."""
    for joint in robot.scalar_joints:
        name, address = robot.names("joint")[joint], int(robot.model.jnt_dofadr[joint])
        for of_model, least in _LEAST.items():
            field = of_model.removeprefix("dof_")
            value = max(float(getattr(robot.model, of_model)[address]), least)
            yield f"{field} of {name}", value, 0.0, _TIMES * value, _joint_writer(name, field)
    for motor, name in enumerate(robot.names("actuator")):
        gain, bias = robot.model.actuator_gainprm[motor].copy(), robot.model.actuator_biasprm[motor].copy()
        yield f"gain of {name}", 1.0, *_GAINS, _gain_writer(name, gain, bias)


def _joint_writer(name: str, field: str) -> Writer:
    def write(spec: mujoco.MjSpec, parameter: Any) -> None:
        joint, value = spec.joint(name), float(parameter.value[0])
        present = getattr(joint, field)
        setattr(joint, field, value if np.isscalar(present) else np.array([value, *np.ravel(present)[1:]]))

    return write


def _gain_writer(name: str, gain: np.ndarray, bias: np.ndarray) -> Writer:
    def write(spec: mujoco.MjSpec, parameter: Any) -> None:
        actuator, factor = spec.actuator(name), float(parameter.value[0])
        actuator.gainprm[:3], actuator.biasprm[:3] = factor * gain[:3], factor * bias[:3]

    return write


def _sequence(spec: mujoco.MjSpec, robot: Robot, recording: Recording) -> Any:
    """A recording as it is taken: commands at the model's steps; readings stamped a step late, as it stamps its own."""
    from mujoco import sysid

    step = float(robot.model.opt.timestep)
    start = sysid.create_initial_state(robot.model, robot.home(), np.zeros(robot.model.nv))
    time = recording.time - recording.time[0]
    readings = sysid.TimeSeries.from_names(time[1:] + step, recording.sensor[1:], robot.model)
    commands = sysid.TimeSeries(*_commands(robot.model, recording))
    return sysid.ModelSequences("robot", spec, [recording.name], [start], [commands], [readings])


def _commands(model: mujoco.MjModel, recording: Recording) -> tuple[np.ndarray, np.ndarray]:
    """Times of the model's steps, s, and the command in force in the middle of each."""
    step, time = float(model.opt.timestep), recording.time - recording.time[0]
    steps = np.arange(int(np.ceil(time[-1] / step)) + 1) * step
    return steps, recording.ctrl[np.clip(np.searchsorted(time, steps + 0.5 * step, side="right") - 1, 0, None)]


def _error(model: mujoco.MjModel, recordings: list[Recording]) -> float:
    """Root mean square over sensors and whole recordings, each as a share of the sensor's range."""
    parts = []
    for recording in recordings:
        data, (steps, commands) = mujoco.MjData(model), _commands(model, recording)
        readings = np.empty((len(steps), model.nsensordata))
        for k, command in enumerate(commands):
            data.ctrl[:] = command
            mujoco.mj_step(model, data)
            readings[k] = data.sensordata  # of the state before the step
        rows = np.clip(np.searchsorted(steps, recording.time - recording.time[0] - 1e-9), 0, len(steps) - 1)
        error = (readings[rows] - recording.sensor) / np.ptp(recording.sensor, axis=0)
        parts.append(np.mean(error**2, axis=0))
    return float(np.sqrt(np.mean(parts)))
