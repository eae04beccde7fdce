"""What a difference between two robots' readings counts for, where all simulators are a few percent wrong.

An ensemble of perturbed simulators about a reference gives deviations X (members x samples, each divided by the root of
the number of members), and a difference e of angles costs

    e' (V + X'X)^-1 e,    V = diag(noise^2 + floor^2 + (share * spread)^2),

by the Woodbury identity with a matrix no larger than the ensemble. The spread (of X, a sample) stands in V because
contacts make deviations nonlinear where they are large.

Touch readings: a sign that differs costs 2 log((1 - p) / p), p being the chance of a flipped reading or of a contact
that the ensemble itself is unsure of; a level off by d, log(1 + (d / tolerance)^2).

Source: errors of a model as a random vector whose covariance an ensemble gives: Evensen, Data Assimilation (2009),
chapter 4.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from estexp_jax.recovery.model_error import FLIPS, NOISE

SAMPLES = 41
"""Readings of a trial that are compared: the first 0.4 s."""
TEMPER = 10.0
"""By how much costs are divided in probabilities; see experiments/diagnosis."""
_FLOOR, _SHARE = 0.004, 0.5
"""Of angles: errors of the integration, rad; share of the spread that is not linear."""
_TOLERANCE = 0.02
"""Of a touch reading's level."""


class Reference(NamedTuple):
    """What a simulator's errors do about one robot."""

    deviations: np.ndarray  #: (members, samples) whitened
    factor: np.ndarray  #: (members, members) Cholesky factor of 1 + X V^-1 X'
    sd: np.ndarray  #: (samples,) root of V
    log_det: float  #: of V + X'X
    unsure: np.ndarray  #: (trials, rows, touches) chance that a touch reading has the other sign


def linearise_errors_at(walk: np.ndarray, touch: np.ndarray, before: np.ndarray) -> Reference:
    """What errors do about the first of some robots, of which the others are perturbed copies.

    Args:
        walk: raw readings (1 + members, trials, rows, n_inputs).
        touch: (n_inputs,) which readings are touch.
        before: (members, samples) deviations of other trials, which come first.
    """
    off = angle_deviations(walk, touch, before)
    sd = np.sqrt(NOISE**2 + _FLOOR**2 + _SHARE**2 * np.sum(off**2, axis=0))
    white = off / sd
    factor = np.linalg.cholesky(np.eye(len(white)) + white @ white.T)
    log_det = 2.0 * (np.sum(np.log(np.diag(factor))) + np.sum(np.log(sd)))
    signs = np.sign(walk[..., touch])
    return Reference(white, factor, sd, float(log_det), np.mean(signs[1:] != signs[0], axis=0))


def angle_deviations(walk: np.ndarray, touch: np.ndarray, before: np.ndarray) -> np.ndarray:
    """The first robot's angles (members, samples), after those of other trials; what blew up tells nothing."""
    found = (walk[1:] - walk[0])[..., ~touch].reshape(len(walk) - 1, -1)
    found = np.where(np.all(np.isfinite(found), axis=1, keepdims=True), found, 0.0)
    return np.concatenate([before, found / np.sqrt(len(found))], axis=1)


def angle_cost(about: Reference, differences: np.ndarray) -> np.ndarray:
    """Costs (n,) of differences of angles (n, samples)."""
    error = differences / about.sd
    explained = np.linalg.solve(about.factor, about.deviations @ error.T)
    return np.sum(error**2, axis=1) - np.sum(explained**2, axis=0)


def touch_cost(about: Reference, seen: np.ndarray, told: np.ndarray) -> np.ndarray:
    """Costs (n,) of touch readings told (n, trials, rows, touches) where others (trials, rows, touches) were seen."""
    p = np.clip(FLIPS + about.unsure, FLIPS, 0.5)
    signs = 2.0 * np.sum((np.sign(seen) != np.sign(told)) * np.log((1.0 - p) / p), axis=(1, 2, 3))
    off = (np.abs(seen) - np.abs(told)) / _TOLERANCE
    return signs + np.sum(np.log1p(off**2), axis=(1, 2, 3))
