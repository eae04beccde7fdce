"""How visible a concealed effect is, decided before anyone explains it, from the truth without noise.

The nominal model is run from the true state of every window of 1 s; then all its masses, dampings, armatures and gains
are refitted within bounds until nothing improves (bounded least squares), with one constant error of each measured
joint's position at the windows' starts where the robot is fixed: who explains the recordings knows starts from the
sensors alone. What remains on the test recordings, in noise floors, is the effect's visibility: what no honest change
of parameters explains. The nominal model's step-size error is subtracted (at the nominal parameters and again at the
fitted ones), so that it does not count as an effect.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from mujoco import rollout
from scipy.optimize import least_squares

from experiments.benchmark.generator.motors import Motors
from experiments.benchmark.generator.plant import Trace
from experiments.benchmark.generator.robots import Layout
from experiments.benchmark.generator.sensing import Channel

WINDOW, SHORT = 1.0, 0.4
"""Length of a window, s; short where there are contacts, which make long ones chaotic."""
MOST = 24
"""Most windows of a role."""


@dataclass(frozen=True)
class Stretch:
    """Windows of some traces.

    Attributes:
        states: (windows, MuJoCo's full physics state) at their starts.
        controls: (windows, steps, actuators) mean commands of each nominal step.
        before, readings: (windows, steps, actuators or channels) commands in force and truth at the steps' ends.
    """

    states: np.ndarray
    controls: np.ndarray
    before: np.ndarray
    readings: np.ndarray


class Refit:
    """A model whose masses, dampings, armatures and gains are scaled by a vector of relative errors.

    The vector ends with errors of the windows' starts, in spans of the joints that are measured.
    """

    def __init__(self, model: mujoco.MjModel, layout: Layout, channels: Sequence[Channel], spans: np.ndarray) -> None:
        """Of a nominal model, which stays as it is.

        Args:
            model: the nominal one.
            layout: where things are in it.
            channels: its sensors.
            spans: (channels,) of their readings.
        """
        self.model = model
        measured = {c.joint: span for c, span in zip(channels, spans, strict=True) if c.kind == "position"}
        measured = {} if layout.free else measured  # servos pull the legs to what is asked within some rows
        self.starts = 1 + layout.q[np.array(list(measured), int)]  # behind the time, in MuJoCo's state
        self.spans = np.nan_to_num(np.array(list(measured.values())), posinf=0.0)
        self.damped, self.turned = np.flatnonzero(model.dof_damping > 0.0), np.flatnonzero(model.dof_armature > 0.0)
        self.slowed = np.flatnonzero(model.actuator_biasprm[:, 2] != 0.0)
        self.sizes = (model.nbody - 1, len(self.damped), len(self.turned), model.nu, len(self.slowed), len(self.starts))

    def at(self, x: np.ndarray) -> mujoco.MjModel:
        """The model at a vector."""
        mass, damping, armature, gain, slow, _ = np.split(1.0 + x, np.cumsum(self.sizes)[:-1])
        m = self.model.__copy__()
        m.body_mass[1:] *= mass
        m.body_inertia[1:] *= mass[:, None]
        m.dof_damping[self.damped] *= damping
        m.dof_armature[self.turned] *= armature
        m.actuator_gainprm[:, 0] *= gain
        m.actuator_biasprm[:, 1] *= gain
        m.actuator_forcerange[:] *= gain[:, None]
        m.actuator_biasprm[self.slowed, 2] *= slow
        mujoco.mj_setConst(m, mujoco.MjData(m))
        return m

    def begun(self, x: np.ndarray, s: Stretch) -> Stretch:
        """Windows that begin elsewhere."""
        states = s.states.copy()
        states[:, self.starts] += self.spans * x[len(x) - len(self.starts) :]
        return replace(s, states=states)


def stretch(model: mujoco.MjModel, traces: Sequence[Trace], readings: Sequence[np.ndarray]) -> Stretch:
    """Cut traces on the nominal steps into windows with all motors on, spread evenly.

    Args:
        model: the nominal one.
        traces: on its steps.
        readings: true readings (steps, channels) of each.
    """
    n = round((SHORT if model.nq != model.nv else WINDOW) / model.opt.timestep)
    found = [
        (i, k) for i, t in enumerate(traces) for k in range(1, len(t.time) - n, n) if t.enable[k - 1 : k + n].all()
    ]
    found = [found[i] for i in np.unique(np.linspace(0, len(found) - 1, MOST).round().astype(int))]
    spec = int(mujoco.mjtState.mjSTATE_FULLPHYSICS)
    states = np.zeros((len(found), mujoco.mj_stateSize(model, spec)))
    for row, (i, k) in enumerate(found):
        states[row, 1 : 1 + model.nq] = traces[i].qpos[k]
        states[row, 1 + model.nq : 1 + model.nq + model.nv] = traces[i].qvel[k]
    cut = [(slice(k, k + n), slice(k + 1, k + n + 1)) for _, k in found]
    controls = np.array([traces[i].command[a] for (i, _), (a, _) in zip(found, cut, strict=True)])
    before = np.array([traces[i].before[b] for (i, _), (_, b) in zip(found, cut, strict=True)])
    return Stretch(
        states, controls, before, np.array([readings[i][b] for (i, _), (_, b) in zip(found, cut, strict=True)])
    )


def predicted(
    model: mujoco.MjModel, s: Stretch, layout: Layout, channels: Sequence[Channel], finer: int = 1
) -> np.ndarray:
    """Readings (windows, steps, channels) of a model over a stretch."""
    model = model.__copy__()
    model.opt.timestep /= finer
    state, _ = rollout.rollout(model, mujoco.MjData(model), s.states, np.repeat(s.controls, finer, axis=1))
    state = np.asarray(state)[:, finer - 1 :: finer]
    q = state[..., 1 : 1 + model.nq][..., layout.q]
    w = state[..., 1 + model.nq : 1 + model.nq + model.nv][..., layout.v]
    motors, columns = Motors.of(model, layout), []
    for c in channels:
        columns.append(q[..., c.joint] if c.kind == "position" else _torque(motors, c.joint, s.before, q, w))
    return np.stack(columns, axis=-1)


def _torque(motors: Motors, joint: int, command: np.ndarray, q: np.ndarray, w: np.ndarray) -> np.ndarray:
    total = np.zeros(q.shape[:2])
    for a, j in enumerate(motors.drives):
        if j == joint:
            u = np.clip(command[..., a], motors.least[a], motors.most[a])
            error = u - q[..., j] if motors.stiffness[a] else u
            total += np.clip(motors.gain[a] * error - motors.damping[a] * w[..., j], motors.low[a], motors.high[a])
    return total


@dataclass(frozen=True)
class Visibility:
    """Errors of nominal and refitted model, all nrmse in noise floors; of a free robot, those of the median window.

    Attributes:
        floor: the noise floor, an nrmse.
        nominal, refit: by role (train, test); `refit` within 30 % of every value.
        step: error of the nominal step alone, on the training windows.
    """

    floor: float
    nominal: dict[str, float]
    refit: dict[str, float]
    step: float


def visibility(
    model: mujoco.MjModel,
    layout: Layout,
    channels: Sequence[Channel],
    stretches: dict[str, Stretch],
    deviations: np.ndarray,
    bound: float = 0.3,
) -> Visibility:
    """Measure how visible the difference between a nominal model and the truth is.

    Args:
        model: the nominal one.
        layout: where things are in it.
        channels: its sensors.
        stretches: windows of training and test recordings.
        deviations: (channels,) of their noise.
        bound: largest relative error of a parameter in the refit; 0: none is made.
    """
    spans = np.array([np.ptp(stretches["train"].readings[..., c]) for c in range(len(channels))])
    spans = np.maximum(spans, 5.0 * deviations)
    spans = np.where(spans > 0.0, spans, np.inf)  # a joint that stands still, seen without noise, shows nothing
    floor = float(np.sqrt(np.mean((deviations / spans) ** 2)))
    refit, roles = Refit(model, layout, channels, spans), tuple(stretches)
    zero = np.zeros(sum(refit.sizes))

    def shifts(x: np.ndarray) -> dict[str, np.ndarray]:
        return {role: step_error(refit.at(x), refit.begun(x, stretches[role]), layout, channels) for role in roles}

    def misfit(x: np.ndarray, role: str, shift: dict[str, np.ndarray]) -> np.ndarray:
        begun = refit.begun(x, stretches[role])
        found = predicted(refit.at(x), begun, layout, channels) + shift[role] - begun.readings
        found = np.nan_to_num(found / spans, nan=1e3, posinf=1e3, neginf=-1e3)
        return np.clip(found, -1e3, 1e3).ravel()

    def errors(x: np.ndarray, shift: dict[str, np.ndarray]) -> dict[str, float]:
        each = {role: misfit(x, role, shift).reshape(len(stretches[role].states), -1) for role in roles}
        typical = np.median if layout.free else np.mean  # where bodies touch, some motions part for good
        return {role: float(np.sqrt(typical(np.mean(e**2, axis=1))) / floor) for role, e in each.items()}

    weight = 1.0 / np.sqrt(stretches["train"].readings.size) / floor
    shift = at_nominal = shifts(zero)
    nominal, best = errors(zero, shift), zero
    nudge = 0.03 if layout.free else 1e-3
    for _ in range(2 if bound > 0.0 else 0):

        def residual(factors: np.ndarray, shift: dict[str, np.ndarray] = shift) -> np.ndarray:
            x = factors - 1.0  # scipy's steps are relative, so about 1 and not about 0
            return np.concatenate([weight * misfit(x, "train", shift), 1e-3 * x / bound])

        limits = (1.0 - bound, 1.0 + bound)
        found = least_squares(
            residual,
            1.0 + best,
            bounds=limits,
            diff_step=nudge,
            max_nfev=24 if layout.free else 8,
            ftol=1e-3,
            xtol=1e-4,
            loss="cauchy" if layout.free else "linear",  # so that motions which part do not decide
            f_scale=3.0 / np.sqrt(stretches["train"].readings.size),  # 3 floors
        )
        best = found.x - 1.0
        shift = shifts(best)
    step = float(np.sqrt(np.mean((at_nominal["train"] / spans) ** 2)) / floor)
    return Visibility(floor, nominal, errors(best, shift), step)


def step_error(model: mujoco.MjModel, s: Stretch, layout: Layout, channels: Sequence[Channel]) -> np.ndarray:
    """What an endlessly fine step would change; the error of MuJoCo's integrators falls with the step (Richardson).

    With contact it does not fall evenly, so a free robot is simulated at a tenth of the step instead.
    """
    finer = 10 if layout.free else 5
    gap = predicted(model, s, layout, channels, finer) - predicted(model, s, layout, channels)
    return gap if layout.free else gap * finer / (finer - 1)
