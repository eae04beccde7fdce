"""A robot with its concealed effects, moved step by step; what it truly did, on two clocks."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import ceil

import mujoco
import numpy as np

from experiments.benchmark.generator.effect import Effect, Moment
from experiments.benchmark.generator.elsewhere import Push
from experiments.benchmark.generator.engines import CEngine, HandEngine
from experiments.benchmark.generator.motors import Motors
from experiments.benchmark.generator.robots import Layout, Robot, layout

FINER = 10
"""Fine steps in a nominal one."""
_EARLY = 0.1
"""So long before the first row it is known what happened, s: delayed sensors show it."""


@dataclass(frozen=True)
class Trace:
    """What truly happened at some times.

    Attributes:
        time: (n,) s, from the first row on; may begin below zero.
        q, w: (n, scalar joints).
        torque: (n, actuators) at the joints, under the command before.
        command: (n, actuators) in force from then on; on the nominal steps, mean over the step that follows.
        before: (n, actuators) in force until then.
        enable: (n, actuators).
        qpos, qvel: the whole state.
    """

    time: np.ndarray
    q: np.ndarray
    w: np.ndarray
    torque: np.ndarray
    command: np.ndarray
    before: np.ndarray
    enable: np.ndarray
    qpos: np.ndarray
    qvel: np.ndarray

    def logged(self) -> Trace:
        """Without what was before the first row."""
        n = int(np.searchsorted(self.time, -1e-9))
        return Trace(**{name: values[n:] for name, values in vars(self).items()})


Controller = Callable[[float, list[float], list[float]], list[float]]
"""Commands from time, positions and speeds."""


class Plant:
    """The robot as it really is."""

    def __init__(
        self, robot: Robot, model: mujoco.MjModel, motors: Motors, effects: Sequence[Effect], by_hand: bool = False
    ) -> None:
        """Of a true model (already perturbed), its motors, and effects made for them."""
        self.robot, self.before, self.motors, self.effects, self.by_hand = robot, model, motors, effects, by_hand
        self.layout: Layout = layout(robot.name)
        self.step = robot.model.opt.timestep / FINER
        self.restarts: list[tuple[float, tuple[np.ndarray, np.ndarray]]] = []

    def run(
        self, controller: Controller, rows: np.ndarray, off: tuple[float, float] | None, warm: float
    ) -> tuple[Trace, Trace]:
        """Move it; gives what happened at the rows, and at the nominal simulator's steps since shortly before them.

        Forces are held over a fine step; they are those of its middle, where position and speed are extrapolated to,
        else the holding would act like a little negative damping and inertia.

        Args:
            controller: asked at every row, and as often before the first.
            rows: times of the rows (s, from 0), whole numbers of fine steps.
            off: from when to when all motors are off.
            warm: how long it moves before the first row, s.
        """
        for effect in self.effects:
            effect.begin()
        dt, steps = self.step, round((rows[-1] + warm) / self.step)
        due = set(np.round((rows + warm) / dt).astype(int).tolist())
        warming = round(float(np.median(np.diff(rows))) / dt)
        first, engine = round(warm / dt), self._engine()
        waiting = sorted((e for e in self.effects), key=lambda e: e.start)
        command, enable = [0.0] * len(self.motors.gain), 1.0
        rowed, stepped = _Log(), _Log()
        last, torque = engine.state()[1], [0.0] * len(command)
        for k in range(steps + 1):
            t = (k - first) * dt
            while waiting and (t >= waiting[0].start or waiting[0].start <= 0.0):
                self._set_in(engine, waiting.pop(0))
            if self.restarts and t >= self.restarts[0][0] - 0.5 * dt:
                engine.set(*self.restarts.pop(0)[1])
            q, w = engine.state()
            is_row = k in due
            before, on_step = command, t >= -_EARLY and (k - first) % FINER == 0
            if is_row or on_step:
                torque = self._moment(t, 0.0, q, w, command, enable).torque
            if is_row or (k < first and (k - first) % warming == 0):
                command = controller(t, q, w)
            if is_row:
                enable = 0.0 if off and off[0] <= t < off[1] else 1.0
                rowed.add(t, q, w, torque, command, before, enable, engine.whole())
            if on_step:
                stepped.add(t, q, w, torque, command, before, enable, engine.whole())
            elif stepped.rows:
                stepped.average(command)
            if k < steps:
                middle = [x + 0.5 * dt * v for x, v in zip(q, w, strict=True)]
                ahead = [v + 0.5 * (v - v0) for v, v0 in zip(w, last, strict=True)]
                engine.advance(self._moment(t, dt, middle, ahead, command, enable).force)
                last = w
        return rowed.trace(), stepped.trace()

    def replay(self, rows: Trace, starts: Mapping[float, tuple[np.ndarray, np.ndarray]]) -> tuple[Trace, Trace]:
        """Move it by logged commands, set anew to given states at some times; hidden states go on through that.

        Args:
            rows: times, commands and enables of the rows.
            starts: qpos and qvel by the time they are set, s.
        """
        command = [c.tolist() for c in rows.command]
        self.restarts = sorted(starts.items(), key=lambda s: s[0])

        def logged(t: float, q: list[float], w: list[float]) -> list[float]:
            return command[int(np.clip(np.searchsorted(rows.time, t + 1e-9) - 1, 0, len(command) - 1))]

        off = rows.time[rows.enable[:, 0] == 0.0]
        found = self.run(logged, rows.time, (float(off[0]), float(off[-1]) + 1e-6) if len(off) else None, 0.0)
        self.restarts = []
        return found

    def _engine(self) -> CEngine | HandEngine:
        if self.by_hand:
            return HandEngine(self._model(), self.robot.name, self.step)
        stiff = mujoco.mjtIntegrator.mjINT_IMPLICIT
        smooth = mujoco.mjtIntegrator.mjINT_RK4
        contact = self.layout.free or any(e.__class__.__name__ == "Jam" for e in self.effects)
        return CEngine(self._model(), self.layout, self.step, int(stiff if contact else smooth))

    def _model(self) -> mujoco.MjModel:
        """The true model with the effects that are there from the start."""
        self.model = self.before.__copy__()
        return self.model

    def _set_in(self, engine: CEngine | HandEngine, effect: Effect) -> None:
        """An effect begins."""
        effect.edit(self.model)
        engine.use(self.model)
        if isinstance(effect, Push):
            engine.push(self.layout.body[effect.at], (effect.x, effect.y, effect.z))

    def _moment(
        self, t: float, dt: float, q: list[float], w: list[float], command: list[float], enable: float
    ) -> Moment:
        """All that acts at a moment; hidden states move on by dt."""
        motors, running = self.motors, [e for e in self.effects if e.start <= t or e.start <= 0.0]
        m = Moment(t, dt, q, w, motors.clipped(command))
        for effect in running:
            effect.command(m)
        m.error = [motors.error(a, u, q) for a, u in enumerate(m.command)]
        for effect in running:
            effect.act(m)
        m.torque = [enable * motors.torque(a, e, w) for a, e in enumerate(m.error)]  # what is off does not warm
        for effect in running:
            effect.motor(m)
        m.torque = [enable * torque for torque in m.torque]  # nor brake
        m.force = [0.0] * len(q)
        for torque, joint in zip(m.torque, motors.drives, strict=True):
            m.force[joint] += torque
        for effect in running:
            effect.transmit(m)
        for effect in running:
            effect.joint(m)
        return m


class _Log:
    """Rows under way."""

    def __init__(self) -> None:
        self.rows: list[tuple] = []

    def add(
        self,
        t: float,
        q: list[float],
        w: list[float],
        torque: list[float],
        command: list[float],
        before: list[float],
        enable: float,
        whole: tuple[np.ndarray, np.ndarray],
    ) -> None:
        """One more."""
        self.rows.append((t, q, w, torque, list(command), list(before), [enable] * len(command), *whole))
        self.sums = 1

    def average(self, command: list[float]) -> None:
        """Another fine step of the last one, under a command."""
        mean = self.rows[-1][4]
        self.sums += 1
        for a, u in enumerate(command):
            mean[a] += (u - mean[a]) / self.sums

    def trace(self) -> Trace:
        """All of them."""
        return Trace(*(np.array(column, dtype=float) for column in zip(*self.rows, strict=True)))


def clock(seconds: float, rate: float, jitter: float, step: float, rng: np.random.Generator) -> np.ndarray:
    """Times of rows (s, from 0) at a rate, each early or late by a share of the period, whole numbers of steps."""
    n = ceil(seconds * rate)
    ideal = np.arange(n) / rate
    offset = np.clip(jitter * rng.standard_normal(n), -0.35, 0.35) / rate
    ticks = np.round((ideal + offset) / step)
    return (ticks - ticks[0]) * step
