"""Cost of differences between readings when simulators have relative errors of a few percent.

An ensemble of perturbed simulators about a reference gives deviations X (members x samples, each divided by the root of
the number of members). A difference e of angles costs

    e' (V + X'X)^-1 e,    V = diag(noise^2 + floor^2 + (share * spread)^2),

computed by the Woodbury identity with a matrix of the ensemble's size. The spread of X in each sample stands in V
because contacts make large deviations nonlinear.

Touch readings: a wrong sign costs 2 log((1 - p) / p), p being the probability of a flipped reading or of another sign
in the ensemble; a level that is off by d costs log(1 + (d / tolerance)^2).

Source: errors of a model as a random vector whose covariance an ensemble gives: Evensen, Data Assimilation (2009),
chapter 4.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from estexp_jax.recovery.model_error import ANGLE_NOISE, FLIP_PROBABILITY

SAMPLES = 41
"""Readings of a trial that are compared: the first 0.4 s."""
TEMPERATURE = 10.0
"""Divisor of costs in probabilities; see experiments/recover/diagnosis."""
_FLOOR, _SHARE = 0.004, 0.5
"""For angles: integration error, rad; share of the spread that is not linear."""
_TOLERANCE = 0.02
"""Tolerance of a touch reading's level."""


class ErrorModel(NamedTuple):
    """Statistics of a simulator's errors about a reference hypothesis."""

    deviations: np.ndarray  #: (members, samples) whitened
    factor: np.ndarray  #: (members, members) Cholesky factor of 1 + X V^-1 X'
    sd: np.ndarray  #: (samples,) root of V
    log_det: float  #: of V + X'X
    unsure: np.ndarray  #: (trials, rows, touches) probability that a touch reading has the other sign


def linearise_errors_at(readings: np.ndarray, touch: np.ndarray, before: np.ndarray) -> ErrorModel:
    """The error model about a reference robot, from its perturbed copies.

    Args:
        readings: raw, (1 + members, trials, rows, n_inputs), the reference first.
        touch: (n_inputs,) whether a reading is touch.
        before: (members, samples) deviations in other trials, which come first.
    """
    deviations = angle_deviations(readings, touch, before)
    sd = np.sqrt(ANGLE_NOISE**2 + _FLOOR**2 + _SHARE**2 * np.sum(deviations**2, axis=0))
    white = deviations / sd
    factor = np.linalg.cholesky(np.eye(len(white)) + white @ white.T)
    log_det = 2.0 * (np.sum(np.log(np.diag(factor))) + np.sum(np.log(sd)))
    signs = np.sign(readings[..., touch])
    return ErrorModel(white, factor, sd, float(log_det), np.mean(signs[1:] != signs[0], axis=0))


def angle_deviations(readings: np.ndarray, touch: np.ndarray, before: np.ndarray) -> np.ndarray:
    """Deviations of angles (members, samples), after those in other trials; 0 where a simulation diverged."""
    found = (readings[1:] - readings[0])[..., ~touch].reshape(len(readings) - 1, -1)
    found = np.where(np.all(np.isfinite(found), axis=1, keepdims=True), found, 0.0)
    return np.concatenate([before, found / np.sqrt(len(found))], axis=1)


def angle_cost(model: ErrorModel, differences: np.ndarray) -> np.ndarray:
    """Costs (n,) of differences of angles (n, samples)."""
    error = differences / model.sd
    explained = np.linalg.solve(model.factor, model.deviations @ error.T)
    return np.sum(error**2, axis=1) - np.sum(explained**2, axis=0)


def touch_cost(model: ErrorModel, measured: np.ndarray, simulated: np.ndarray) -> np.ndarray:
    """Costs (n,) of simulated touch readings (n, trials, rows, touches) against measured (trials, rows, touches)."""
    p = np.clip(FLIP_PROBABILITY + model.unsure, FLIP_PROBABILITY, 0.5)
    signs = 2.0 * np.sum((np.sign(measured) != np.sign(simulated)) * np.log((1.0 - p) / p), axis=(1, 2, 3))
    deviations = (np.abs(measured) - np.abs(simulated)) / _TOLERANCE
    return signs + np.sum(np.log1p(deviations**2), axis=(1, 2, 3))
