"""Genomes of motions, their limits, and the separation of competing models' predictions.

Sources: Bongard and Lipson, Evolving Robot Morphology and Control (2004), and Automated Reverse Engineering of
Nonlinear Dynamical Systems (2007): the best test is the one on which candidate models disagree most. Deb, An Efficient
Constraint Handling Method for Genetic Algorithms (2000): any violation of a limit is worse than none.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from estexp_jax.experiment_design.excitation import Wave, excitation_range, ramp_and_hold, ramps, random_levels, sines
from estexp_jax.physics.model.robot import Robot

_WAVES: tuple[Wave, ...] = (sines, random_levels, ramps, ramp_and_hold)
GENES = len(_WAVES) + 3
"""Values of a genome for each actuator: amplitude of each wave, strength, pace, seed."""
STILL = 0.5
"""Time at the beginning during which the robot is held at home, s."""
_LEAST_STRENGTH = 0.03
"""Least strength of a motion, as a share of an actuator's range; strengths are drawn uniformly in their logarithm."""
_PACE_FACTOR = 2.5
"""Factor by which motions may be faster or slower than those of `excitation`."""
_LEAST_PROBABILITY = 0.01
"""Least probability of a model in the score."""


@final
@dataclass(frozen=True, eq=False)
class Limits:
    """Limits of a motion.

    Attributes:
        centre, reach: (nu,) initial commands, and the amplitude of waves about them.
        low, high: (nu,) bounds of commands.
        qpos_addresses: (joints,) of the joints with a range.
        lowest, highest: (joints,) their bounds, rad or m.
        speeds: (nv,) largest speeds, rad/s or m/s; infinite where there is no limit.
    """

    centre: np.ndarray
    reach: np.ndarray
    low: np.ndarray
    high: np.ndarray
    qpos_addresses: np.ndarray
    lowest: np.ndarray
    highest: np.ndarray
    speeds: np.ndarray

    def excess(self, qpos: np.ndarray, qvel: np.ndarray) -> float:
        """Largest violation by motions (..., nq), (..., nv), as a share of a joint's half range or speed limit."""
        half = np.maximum((self.highest - self.lowest) / 2.0, 1e-9)
        position = qpos[..., self.qpos_addresses]
        beyond = np.maximum(position - self.highest, self.lowest - position) / half
        faster = np.abs(qvel) / self.speeds - 1.0
        return float(max(np.max(beyond, initial=0.0), np.max(faster, initial=0.0)))


def limits_of(robot: Robot, margin: float, commands: np.ndarray, speeds: np.ndarray) -> Limits:
    """Limits of a robot: shares of its command and joint ranges.

    Motors without a command range are limited to that share of their force, servos to their usual range; or to the
    range in the recordings, where that is wider.

    Args:
        robot: the nominal robot.
        margin: share of each range that may be used; home is always inside.
        commands: (nu, 2) lowest and highest command in the recordings.
        speeds: (nv,) limits, rad/s or m/s; infinite where there is none.
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
    qpos_addresses = model.jnt_qposadr[joints] if joints else np.zeros(0, int)
    lowest, highest = _shrunk(model.jnt_range[joints].reshape(-1, 2), margin, robot.home()[qpos_addresses])
    return Limits(centre, reach, low, high, qpos_addresses, lowest, highest, speeds)


def _shrunk(ranges: np.ndarray, margin: float, home: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The middle `margin` of ranges (n, 2), wide enough to hold home (n,)."""
    middle, half = ranges.mean(axis=1), margin * np.ptp(ranges, axis=1) / 2.0
    return np.minimum(middle - half, home), np.maximum(middle + half, home)


def decode_commands(limits: Limits, time: np.ndarray, genome: np.ndarray) -> np.ndarray:
    """The commands (rows, nu) of a genome; the robot stays at home for the first `STILL` seconds.

    Args:
        limits: of the commands.
        time: (rows,) s.
        genome: (GENES * nu,) in -1..1.
    """
    moving = np.maximum(time - time[0] - STILL, 0.0)
    signals = [_mixed(genes, moving, a) for a, genes in enumerate(genome.reshape(-1, GENES))]
    return np.clip(limits.centre + limits.reach * np.stack(signals, axis=1), limits.low, limits.high)


def _mixed(genes: np.ndarray, moving: np.ndarray, actuator: int) -> np.ndarray:
    """A signal (rows,) in -1..1 of one actuator: a sum of waves. Amplitudes are cubed, so that one often dominates."""
    amounts, (strength, pace, seed) = genes[: len(_WAVES)] ** 3, genes[len(_WAVES) :]
    draw = np.random.default_rng([actuator, round(100.0 * (seed + 1.0))])
    total = sum(amount * wave(_PACE_FACTOR**pace * moving, draw) for amount, wave in zip(amounts, _WAVES, strict=True))
    peak = max(float(np.abs(total).max()), 1e-9)
    return _LEAST_STRENGTH ** ((1.0 - strength) / 2.0) * total / peak


def random_motion(limits: Limits, time: np.ndarray, strength: float, seed: int) -> np.ndarray:
    """Commands (rows, nu) for comparison: sums of sines with a share `strength` of each command's amplitude."""
    draw, moving = np.random.default_rng([seed, len(time)]), np.maximum(time - time[0] - STILL, 0.0)
    signals = np.stack([sines(moving, draw) for _ in limits.centre], axis=1)
    return np.clip(limits.centre + strength * limits.reach * signals, limits.low, limits.high)


def pairwise_separation(readings: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Separation (models, models) of predictions, beyond what ordinary model errors explain, in standard deviations.

        s_ij^2 = min_a |d_ij - D a|^2 / rows + |a|^2 = d' (I + D D' / rows)^-1 d / rows

    d_ij is the difference of two models' readings in standard deviations of the noise, all channels together. A single
    sensor that differs by three deviations in every row gives 3, however many others the robot has. An ordinary error
    a of one costs as much as one deviation in every row.

    Args:
        readings: (models, rows, channels), in standard deviations.
        directions: D, (directions, rows, channels): changes of the readings by one ordinary error each.
    """
    n, rows = readings.shape[:2]
    flat = readings.reshape(n, -1) / np.sqrt(rows)
    spread = directions.reshape(len(directions), flat.shape[1]) / np.sqrt(rows)
    difference = flat[:, None] - flat[None]
    projected = difference @ spread.T
    inner = np.linalg.inv(np.eye(len(spread)) + spread @ spread.T)  # Woodbury: of directions, not of samples
    squares = np.sum(difference**2, axis=2) - np.einsum("ijm,mn,ijn->ij", projected, inner, projected)
    return np.sqrt(np.maximum(squares, 0.0))


def pairwise_separation_sensitive(readings: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """As `pairwise_separation`, for robots that are sensitive to their initial state, such as robots on legs.

    Their response to ordinary errors is not linear, so the changes count as noise, reading by reading:

        s_ij^2 = sum d_ij^2 / (1 + sum_k D_k^2) / rows

    Args:
        readings: (models, rows, channels), in standard deviations.
        directions: D, (directions, rows, channels).
    """
    rows = readings.shape[1]
    difference = (readings[:, None] - readings[None]) / np.sqrt(1.0 + np.sum(directions**2, axis=0))
    return np.sqrt(np.sum(difference**2, axis=(2, 3)) / rows)


def separation_score(separation: np.ndarray, probabilities: np.ndarray) -> float:
    """Score of the separation of all models: a soft minimum over pairs, weighted by their probabilities.

        S = (sum_{i<j} w_ij / (1 + s_ij^2) / sum_{i<j} w_ij)^(-1/2),  w_ij = p_i p_j

    The least separated pair dominates. A pair that no motion separates does not hide the gain on others.

    Args:
        separation: (models, models) as of `pairwise_separation`.
        probabilities: (models,).
    """
    shares = np.maximum(probabilities, _LEAST_PROBABILITY)
    one, other = np.triu_indices(len(separation), 1)
    weights = shares[one] * shares[other]
    return float(np.sqrt(weights.sum() / np.sum(weights / (1.0 + separation[one, other] ** 2))))
