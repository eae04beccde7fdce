"""What a case's sensors read, without noise and spoilt by sensor effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict

import mujoco
import numpy as np

from experiments.benchmark.generator.case import Planted, Recorded
from experiments.benchmark.generator.catalogue import CATALOGUE
from experiments.benchmark.generator.effect import Effect
from experiments.benchmark.generator.plant import Trace
from experiments.benchmark.generator.robots import layout
from experiments.benchmark.generator.sensing import Channel, true_reading


def every(trace: Trace, n: int) -> Trace:
    """Every n-th row; commands are averaged over the rows between."""
    if n == 1:
        return trace
    whole = len(trace.time) // n * n
    mean = trace.command[:whole].reshape(-1, n, trace.command.shape[1]).mean(axis=1)
    thinned = {k: v[:whole:n] for k, v in asdict(trace).items()}
    return Trace(**{**thinned, "command": mean})


def size_of(channel: Channel, recorded: Sequence[Recorded], robot: str) -> float:
    """Deviation of a sensor's true reading over all recordings."""
    return float(np.std(np.concatenate([true_reading(channel, r.steps, layout(robot)) for r in recorded])))


def is_slide(model: mujoco.MjModel, place, channel: Channel) -> bool:
    """Whether a sensor's joint is a slide."""
    return int(model.joint(place.joints[channel.joint]).type[0]) == int(mujoco.mjtJoint.mjJNT_SLIDE)


def reading(
    channel: Channel,
    recorded: Recorded,
    at: np.ndarray,
    effects: Sequence[Effect],
    planted: Sequence[Planted],
    robot: str,
) -> np.ndarray:
    """A sensor's reading without noise at some times, spoilt by sensor effects, one after the other."""
    time, true = recorded.whole.time, true_reading(channel, recorded.whole, layout(robot))
    spoilt = None
    for effect, p in zip(effects, planted, strict=True):
        if CATALOGUE[p.effect].kind == "sensor" and p.joint == channel.joint and channel.kind == "position":
            effect.start = -1e9 if recorded.onset is None else recorded.onset
            found = effect.read(time, true, at)
            if found is not None:
                spoilt, true = found, np.asarray(effect.read(time, true, time))
    if spoilt is not None:
        return spoilt
    if channel.kind == "torque":  # jumps with commands, so taken where it was read
        return (
            true_reading(channel, recorded.rows, layout(robot))
            if len(at) == len(recorded.rows.time)
            else np.interp(at, time, true)
        )
    return np.interp(at, time, true)
