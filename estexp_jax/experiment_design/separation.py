"""The most separating command: motions as genomes, and how far apart rivals' predictions of them are.

Sources: Bongard and Lipson, Evolving Robot Morphology and Control (2004), and Automated Reverse Engineering of
Nonlinear Dynamical Systems (2007): the best test is the one that rival models disagree on most. Deb, An Efficient
Constraint Handling Method for Genetic Algorithms (2000): what breaks a limit is worse than anything that does not.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from estexp_jax.experiment_design.excitation import Wave, excitation_range, ramp_and_hold, ramps, random_levels, sines
from estexp_jax.physics.model.robot import Robot

_WAVES: tuple[Wave, ...] = (sines, random_levels, ramps, ramp_and_hold)
GENES = len(_WAVES) + 3
"""Values of a genome for each actuator: how much of each wave, strength, pace, seed."""
STILL = 0.5
"""Time at the beginning for which a robot is held at home, s."""
_WEAKEST = 0.03
"""Least strength of a motion, as a share of an actuator's reach; strengths between are as likely by factors."""
_PACE = 2.5
"""Factor by which motions may be faster or slower than those of `excitation`."""
_IMPROBABLE = 0.01
"""Least probability that a rival counts with."""


@final
@dataclass(frozen=True, eq=False)
class Limits:
    """What a motion may not go beyond.

    Attributes:
        centre, reach: (nu,) where commands begin, and how far waves go from there.
        low, high: (nu,) bounds of commands.
        places: (joints,) addresses in qpos of the joints with a range.
        lowest, highest: (joints,) their bounds.
        speeds: (nv,) fastest speeds; infinite where there is no limit.
    """

    centre: np.ndarray
    reach: np.ndarray
    low: np.ndarray
    high: np.ndarray
    places: np.ndarray
    lowest: np.ndarray
    highest: np.ndarray
    speeds: np.ndarray

    def excess(self, qpos: np.ndarray, qvel: np.ndarray) -> float:
        """How far motions (..., nq), (..., nv) go beyond: the largest share of a joint's half range or speed limit."""
        half = np.maximum((self.highest - self.lowest) / 2.0, 1e-9)
        there = qpos[..., self.places]
        beyond = np.maximum(there - self.highest, self.lowest - there) / half
        faster = np.abs(qvel) / self.speeds - 1.0
        return float(max(np.max(beyond, initial=0.0), np.max(faster, initial=0.0)))


def limits_of(robot: Robot, margin: float, commands: np.ndarray, speeds: np.ndarray) -> Limits:
    """Limits of a robot: shares of its ranges of command and joint.

    Motors without a range of command go to that share of their force, servos without one to their usual reach; or as
    far as in the recordings, where that is further.

    Args:
        robot: the nominal robot.
        margin: share of each range that may be used; home always may.
        commands: (nu, 2) lowest and highest command of recordings.
        speeds: (nv,) limits; infinite where there is none.
    """
    model = robot.model
    centre, reach = excitation_range(robot)
    limited = np.flatnonzero(model.actuator_ctrllimited)
    reach[limited] = np.abs(model.actuator_ctrlrange[limited] - centre[limited, None]).min(axis=1)
    reach = np.fmax(margin * reach, np.abs(commands - centre[:, None]).max(axis=1, initial=0.0))
    low, high = centre - reach, centre + reach
    least, most = _shrunk(model.actuator_ctrlrange[limited], margin, centre[limited])
    low[limited], high[limited] = np.maximum(low[limited], least), np.minimum(high[limited], most)
    joints = [j for j in robot.scalar_joints if model.jnt_limited[j]]
    places = model.jnt_qposadr[joints] if joints else np.zeros(0, int)
    lowest, highest = _shrunk(model.jnt_range[joints].reshape(-1, 2), margin, robot.home()[places])
    return Limits(centre, reach, low, high, places, lowest, highest, speeds)


def _shrunk(ranges: np.ndarray, margin: float, home: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The middle `margin` of ranges (n, 2), wide enough to hold home (n,)."""
    middle, half = ranges.mean(axis=1), margin * np.ptp(ranges, axis=1) / 2.0
    return np.minimum(middle - half, home), np.maximum(middle + half, home)


def decode_commands(limits: Limits, time: np.ndarray, genome: np.ndarray) -> np.ndarray:
    """The commands (rows, nu) of a genome; still at home for the first moment.

    Args:
        limits: that they keep to.
        time: (rows,) s.
        genome: (GENES * nu,) in -1..1.
    """
    moving = np.maximum(time - time[0] - STILL, 0.0)
    signals = [_mixed(genes, moving, a) for a, genes in enumerate(genome.reshape(-1, GENES))]
    return np.clip(limits.centre + limits.reach * np.stack(signals, axis=1), limits.low, limits.high)


def _mixed(genes: np.ndarray, moving: np.ndarray, actuator: int) -> np.ndarray:
    """A signal (rows,) in -1..1 of one actuator: waves added up; cubes, so that some are nearly pure."""
    amounts, (strength, pace, seed) = genes[: len(_WAVES)] ** 3, genes[len(_WAVES) :]
    draw = np.random.default_rng([actuator, round(100.0 * (seed + 1.0))])
    total = sum(amount * wave(_PACE**pace * moving, draw) for amount, wave in zip(amounts, _WAVES, strict=True))
    peak = max(float(np.abs(total).max()), 1e-9)
    return _WEAKEST ** ((1.0 - strength) / 2.0) * total / peak


def random_motion(limits: Limits, time: np.ndarray, strength: float, seed: int) -> np.ndarray:
    """Commands (rows, nu) that know nothing of rivals: sums of sines to a share `strength` of each command's reach."""
    draw, moving = np.random.default_rng([seed, len(time)]), np.maximum(time - time[0] - STILL, 0.0)
    signals = np.stack([sines(moving, draw) for _ in limits.centre], axis=1)
    return np.clip(limits.centre + strength * limits.reach * signals, limits.low, limits.high)


def pairwise_separation(readings: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """How far apart rivals (rivals, rivals) are, beyond what ordinary errors of a model explain; 1 is one deviation.

        s_ij^2 = min_a |d_ij - D a|^2 / rows + |a|^2 = d' (I + D D' / rows)^-1 d / rows

    d_ij is the difference of two rivals' readings in deviations of their noise, all channels together: a lone sensor
    that differs by three deviations all the time gives 3, however many others the robot has. A model's value that is
    off by as much as is ordinary costs as much as one deviation all the time.

    Args:
        readings: (rivals, rows, channels), in deviations.
        directions: D, (directions, rows, channels): what ordinary errors, one at a time, change in them.
    """
    rivals, rows = readings.shape[:2]
    flat = readings.reshape(rivals, -1) / np.sqrt(rows)
    spread = directions.reshape(len(directions), flat.shape[1]) / np.sqrt(rows)
    apart = flat[:, None] - flat[None]
    shown = apart @ spread.T
    inner = np.linalg.inv(np.eye(len(spread)) + spread @ spread.T)  # Woodbury: of directions, not of samples
    squares = np.sum(apart**2, axis=2) - np.einsum("ijm,mn,ijn->ij", shown, inner, shown)
    return np.sqrt(np.maximum(squares, 0.0))


def pairwise_separation_sensitive(readings: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """As `pairwise_separation`, for robots that part for good once a foot touches down a moment sooner.

    There no few directions hold what ordinary errors do, so what they change counts as noise, reading by reading:

        s_ij^2 = sum d_ij^2 / (1 + sum_k D_k^2) / rows

    Args:
        readings: (rivals, rows, channels), in deviations.
        directions: D, (directions, rows, channels).
    """
    rows = readings.shape[1]
    apart = (readings[:, None] - readings[None]) / np.sqrt(1.0 + np.sum(directions**2, axis=0))
    return np.sqrt(np.sum(apart**2, axis=(2, 3)) / rows)


def separation_score(apart: np.ndarray, probabilities: np.ndarray) -> float:
    """One number for how well rivals are told apart: a soft minimum over pairs, weighted by both probabilities.

        S = (sum_{i<j} w_ij / (1 + s_ij^2) / sum_{i<j} w_ij)^(-1/2),  w_ij = p_i p_j

    The least separated pair rules it; yet a pair that no motion separates does not hide what is gained with others.

    Args:
        apart: (rivals, rivals) as of `pairwise_separation`.
        probabilities: (rivals,).
    """
    shares = np.maximum(probabilities, _IMPROBABLE)
    one, other = np.triu_indices(len(apart), 1)
    weights = shares[one] * shares[other]
    return float(np.sqrt(weights.sum() / np.sum(weights / (1.0 + apart[one, other] ** 2))))
