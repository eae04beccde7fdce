"""Claims that a look at the recordings rules out, before anything is simulated or by the values that were found."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from estexp_jax.discovery.hypotheses import Place
from estexp_jax.discovery.slopes import Fit
from estexp_jax.discovery.starts import Seen
from estexp_jax.estimation.noise import noise_std_of
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording

_LAST = 2 / 3
"""Share of a recording after which a fault that begins part-way has begun."""
_STILL = 5.0
"""Deviations of its noise by which a sensor that is stuck may still waver."""


def possible(robot: Robot, place: Place, recordings: Sequence[Recording]) -> bool:
    """Whether an effect at a place can be what training recordings show: a sensor that moves is not stuck."""
    name, site = place
    if name != "sensor_stuck":
        return True
    return all(_still(robot, r, site, _LAST) for r in recordings if r.role == "train")


def conceivable(robot: Robot, fitted: Fit, seen: Seen) -> bool:
    """Whether training recordings can show what a fit claims: half a wave is the least of cogging."""
    for change in fitted.hypothesis.changes(fitted.vector, claimed=True):
        if change.effect == "cogging":
            place = int(robot.model.jnt_qposadr[robot.index("joint", str(change.name))])
            if change.values["n"] * (seen.high[place] - seen.low[place]) < np.pi:
                return False
    return True


def still_throughout(robot: Robot, sensor: str, recordings: Sequence[Recording]) -> bool:
    """Whether training recordings show a sensor at one value from the first row on."""
    return all(_still(robot, r, sensor, 0.0) for r in recordings if r.role == "train")


def _still(robot: Robot, recording: Recording, sensor: str, begin: float) -> bool:
    """Whether a sensor holds still but for its noise, from a share of a recording on."""
    column = int(robot.model.sensor_adr[robot.index("sensor", sensor)])
    rows = slice(int(begin * recording.rows), None)
    time, samples = recording.time[rows], recording.sensor[rows, column]
    known = samples[np.isfinite(samples)]
    if len(known) < 5:
        return True
    rounding = 1e-9 * float(np.abs(known).max())
    return bool(known.std() <= _STILL * noise_std_of(time, samples) + rounding)
