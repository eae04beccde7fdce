"""The objective about a point: whitened residuals and derivatives, ready for linear algebra.

A window's residual is measurement noise, the initial state's error, and what the model still lacks. The last is
correlated over the whole window; a window and channel so counts as few independent data, however many rows it has.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from estexp_jax.estimation.dataset import Dataset
from estexp_jax.estimation.objective import Responses


class Linearised(NamedTuple):
    """Whitened windows about a point.

    Attributes:
        residual: (data,) measured less simulated, in standard deviations.
        columns: (data, directions) change of the simulated readings, in the same unit.
        cost: mean square of the residuals that are not whitened, in squares of `noise`.
        observations: how many independent data there are.
        window: (data,) index of each datum's window.
    """

    residual: np.ndarray
    columns: np.ndarray
    cost: float
    observations: float
    window: np.ndarray


def reading_noise_of(data: Dataset, simulated: np.ndarray, least: np.ndarray, clip: float) -> np.ndarray:
    """Standard deviation (channels,) of what is left, of measurement noise and model error together.

    Args:
        data: the windows.
        simulated: (windows, rows, channels).
        least: (channels,) noise of the readings alone.
        clip: residuals count as at most so many median ones.
    """
    left = data.measurements - simulated
    left = left[np.isfinite(left).any(axis=2)]
    usual = np.nanmedian(np.abs(left), axis=0) / 0.6745
    bounded = np.clip(left, -clip * usual, clip * usual)
    return np.sqrt(np.maximum(np.nanmean(bounded**2, axis=0), least**2))


def independent_data(data: Dataset, correlation_time: float) -> np.ndarray:
    """How many independent data there are in each window (windows,) and channel, one at least."""
    return np.maximum(data.durations / correlation_time, 1.0)


def linearised(data: Dataset, found: Responses, noise: np.ndarray, correlation_time: float, clip: float) -> Linearised:
    """Whiten windows by measurement noise, model error and the initial states' covariance.

    Args:
        data: the windows.
        found: simulated about the point.
        noise: (channels,) standard deviation of noise and model error together.
        correlation_time: how long a model error lasts, s: so often there is an independent datum in a channel.
        clip: residuals count as at most so many standard deviations.
    """
    residuals, columns, owners = [], [], []
    left = data.measurements - found.point
    known = np.isfinite(left)
    independent = independent_data(data, correlation_time)
    costs = np.clip(np.where(known, left, 0.0) / noise, -clip * 10.0, clip * 10.0)[known]
    for w in range(len(left)):
        there = known[w]
        if not there.any():
            continue
        rows = max(float(there.sum(axis=0).max()), 1.0)
        std = np.broadcast_to(noise * np.sqrt(max(rows / independent[w], 1.0)), there.shape)[there]
        start = np.nan_to_num(found.initial_state[:, w][:, there]).T
        own = np.concatenate([left[w][there][:, None], np.nan_to_num(found.change[:, w][:, there]).T], axis=1)
        white = _whitened(own / std[:, None], start / std[:, None])
        size = np.sqrt(np.mean(white[:, 0] ** 2) * len(white) / (independent[w] * there.shape[1]))
        white *= min(1.0, clip / max(size, 1e-12))  # a window that is far off counts as one that is `clip` off
        residuals.append(white[:, 0])
        columns.append(white[:, 1:])
        owners.append(np.full(len(white), w))
    count = float(sum(n * k.any(axis=0).sum() for n, k in zip(independent, known, strict=True)))
    return Linearised(
        np.concatenate(residuals), np.concatenate(columns), float(np.mean(costs**2)), count, np.concatenate(owners)
    )


def _whitened(x: np.ndarray, spread: np.ndarray) -> np.ndarray:
    """Rows of x (data, n) times the inverse square root of the covariance 1 + spread spread^T.

    Args:
        x: in standard deviations of independent noise.
        spread: (data, few) what is common to the data besides, in the same unit.
    """
    directions, sizes, _ = np.linalg.svd(spread, full_matrices=False)
    shrunk = 1.0 - 1.0 / np.sqrt(1.0 + sizes**2)
    return x - directions @ (shrunk[:, None] * (directions.T @ x))
