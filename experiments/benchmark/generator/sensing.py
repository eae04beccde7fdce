"""What sensors make of the truth: encoder steps, white and coloured noise, dropped rows, stamps a little off."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from experiments.benchmark.generator.plant import Trace
from experiments.benchmark.generator.robots import Layout


@dataclass(frozen=True)
class Channel:
    """A sensor of the nominal model.

    Attributes:
        name: in the MJCF.
        kind: `position` or `torque`.
        joint: index of its scalar joint.
    """

    name: str
    kind: str
    joint: int


@dataclass(frozen=True)
class Instruments:
    """How good a case's instruments are.

    Attributes:
        bits: of the encoders, over a turn or a metre.
        white, coloured: deviation of position noise as a share of an encoder step; the coloured one is AR(1).
        torque: deviation of torque noise as a share of the torque's own, AR(1).
        jitter: deviation of the rows' times as a share of the period.
        dropped: share of the rows that is lost.
        stamp: deviation of the time stamps, s.
        memory: of the torque noise, from row to row.
    """

    bits: int
    white: float
    coloured: float
    torque: float
    jitter: float
    dropped: float
    stamp: float = 2e-5
    memory: float = 0.7

    @staticmethod
    def draw(rng: np.random.Generator) -> Instruments:
        """Ordinary instruments."""
        return Instruments(
            bits=int(rng.choice([12, 13, 14])),
            white=float(rng.uniform(0.2, 0.7)),
            coloured=float(rng.uniform(0.1, 0.4)),
            torque=float(rng.uniform(0.005, 0.02)),
            jitter=float(rng.uniform(0.0, 0.08)),
            dropped=float(rng.choice([0.0, 0.002, 0.01])),
        )

    def step(self) -> float:
        """An encoder's step, rad; slides: m / 2 pi of it."""
        return 2.0 * np.pi / 2**self.bits


MOCAP = {"position": 3e-4, "turn": 6e-4, "speed": 4e-3, "spin": 1e-2}
"""Deviation of motion capture: m, quaternion, m/s, rad/s."""


def channels(model: mujoco.MjModel, layout: Layout) -> list[Channel]:
    """The sensors of a nominal model."""
    kinds = {int(mujoco.mjtSensor.mjSENS_JOINTPOS): "position", int(mujoco.mjtSensor.mjSENS_JOINTACTFRC): "torque"}
    found = []
    for s in range(model.nsensor):
        joint = model.joint(int(model.sensor_objid[s])).name
        found.append(Channel(model.sensor(s).name, kinds[int(model.sensor_type[s])], layout.joints.index(joint)))
    return found


def true_reading(channel: Channel, trace: Trace, layout: Layout) -> np.ndarray:
    """What a perfect sensor reads."""
    if channel.kind == "position":
        return trace.q[:, channel.joint]
    driving = [a for a, j in enumerate(layout.drives) if j == channel.joint]
    return trace.torque[:, driving].sum(axis=1)


def coloured(n: int, memory: float, rng: np.random.Generator) -> np.ndarray:
    """AR(1) noise of deviation 1."""
    white = rng.standard_normal(n) * np.sqrt(1.0 - memory**2)
    white[0] = rng.standard_normal()
    for i in range(1, n):
        white[i] += memory * white[i - 1]
    return white


def deviation(channel: Channel, instruments: Instruments, size: float, slide: bool) -> float:
    """Deviation of a channel's error: noise and encoder step together.

    Args:
        channel: which.
        instruments: how good they are.
        size: deviation of the true reading.
        slide: whether its joint is one.
    """
    if channel.kind == "torque":
        return instruments.torque * size
    step = instruments.step() / (2.0 * np.pi if slide else 1.0)
    return float(step * np.sqrt(instruments.white**2 + instruments.coloured**2 + 1.0 / 12.0))


def measured(
    channel: Channel, true: np.ndarray, instruments: Instruments, size: float, slide: bool, rng: np.random.Generator
) -> np.ndarray:
    """A reading as logged; arguments as of `deviation`."""
    n = len(true)
    if channel.kind == "torque":
        return np.round(true + instruments.torque * size * coloured(n, instruments.memory, rng), 5)
    step = instruments.step() / (2.0 * np.pi if slide else 1.0)
    noise = instruments.white * rng.standard_normal(n) + instruments.coloured * coloured(n, 0.9, rng)
    return np.round((true + step * noise) / step) * step


def captured(trace: Trace, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Free joint's qpos (rows, 7) and qvel (rows, 6) from motion capture."""
    qpos, qvel = trace.qpos[:, :7].copy(), trace.qvel[:, :6].copy()
    n = len(qpos)
    qpos[:, :3] += MOCAP["position"] * rng.standard_normal((n, 3))
    qpos[:, 3:] += MOCAP["turn"] * rng.standard_normal((n, 4))
    qpos[:, 3:] /= np.linalg.norm(qpos[:, 3:], axis=1, keepdims=True)
    qvel[:, :3] += MOCAP["speed"] * rng.standard_normal((n, 3))
    qvel[:, 3:] += MOCAP["spin"] * rng.standard_normal((n, 3))
    return qpos, qvel
