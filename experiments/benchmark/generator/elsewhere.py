"""Effects in sensors, bodies and surroundings."""

from __future__ import annotations

from math import cos, sin

import mujoco
import numpy as np

from experiments.benchmark.generator.effect import Effect


class Gain(Effect):
    """reading = gain * true."""

    def read(self, time: np.ndarray, true: np.ndarray, at: np.ndarray) -> np.ndarray:
        return np.interp(at, time, true) * np.where(at < self.start, 1.0, self.gain)


class Bias(Effect):
    """reading = true + bias."""

    def read(self, time: np.ndarray, true: np.ndarray, at: np.ndarray) -> np.ndarray:
        return np.interp(at, time, true) + np.where(at < self.start, 0.0, self.bias)


class DelayedReading(Effect):
    """The reading of some time ago."""

    def read(self, time: np.ndarray, true: np.ndarray, at: np.ndarray) -> np.ndarray:
        return np.interp(at - np.where(at < self.start, 0.0, self.delay), time, true)


class Stuck(Effect):
    """A reading that stays."""

    def read(self, time: np.ndarray, true: np.ndarray, at: np.ndarray) -> np.ndarray:
        return np.where(at < self.start, np.interp(at, time, true), self.value)


class Drift(Effect):
    """A reading that walks away: true + rate * t."""

    def read(self, time: np.ndarray, true: np.ndarray, at: np.ndarray) -> np.ndarray:
        return np.interp(at, time, true) + self.rate * np.maximum(at - max(self.start, 0.0), 0.0)


class Payload(Effect):
    """A heavier body, its inertia scaled with its mass."""

    def edit(self, model: mujoco.MjModel) -> None:
        b = model.body(self.layout.body[self.at]).id if self.at >= 0 else 1
        factor = 1.0 + self.dm / model.body_mass[b]
        model.body_mass[b] *= factor
        model.body_inertia[b] *= factor


class ComShift(Effect):
    """Another centre of mass."""

    def edit(self, model: mujoco.MjModel) -> None:
        b = model.body(self.layout.body[self.at]).id
        model.body_ipos[b] += [self.x, self.y, self.z]


class ZeroOffset(Effect):
    """The body is mounted at another angle than the model says: where the model has zero, the joint shows `offset`."""

    def edit(self, model: mujoco.MjModel) -> None:
        b = model.body(self.layout.body[self.at]).id
        axis = model.jnt_axis[model.joint(self.layout.joints[self.at]).id]
        turn, result = np.zeros(4), np.zeros(4)
        mujoco.mju_axisAngle2Quat(turn, axis, -self.offset)
        mujoco.mju_mulQuat(result, model.body_quat[b], turn)
        model.body_quat[b] = result


class Lost(Effect):
    """A body and all it carries, gone but for a stub; its motor turns in the void."""

    def edit(self, model: mujoco.MjModel) -> None:
        gone = {model.body(self.layout.body[self.at]).id}
        for b in range(1, model.nbody):
            if b in gone or int(model.body_parentid[b]) in gone:
                gone.add(b)
                model.body_mass[b] *= 0.01
                model.body_inertia[b] *= 0.01
        for g in range(model.ngeom):
            if int(model.geom_bodyid[g]) in gone:
                model.geom_contype[g] = model.geom_conaffinity[g] = 0


class Tilt(Effect):
    """Gravity turned by an angle about x (axis 0) or y (axis 1)."""

    def edit(self, model: mujoco.MjModel) -> None:
        g, c, s = -9.81, cos(self.angle), sin(self.angle)
        model.opt.gravity[:] = [0.0, -g * s, g * c] if self.axis == 0.0 else [g * s, 0.0, g * c]


class Slippery(Effect):
    """Another friction between feet and floor."""

    def edit(self, model: mujoco.MjModel) -> None:
        model.geom_friction[:, 0] = self.mu


class Push(Effect):
    """A constant force on a body, at its centre of mass, in world axes; the plant applies it."""
