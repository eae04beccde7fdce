"""The paper's two metrics of the error of a simulated trial. Lower is better.

Source: Bongard and Lipson 2004, section 2.2, equations 1 to 3.
"""

from __future__ import annotations

import numpy as np


def rolling_mean(physical: np.ndarray, simulated: np.ndarray, *, header: int = 20, window: int = 10) -> np.ndarray:
    """Equation 2: mean over trials, sensors and windows of the windows' mean absolute difference.

    f = sum_i sum_j sum_{k = w/2}^{h - w/2} d(i, j, k) / (c n (h - w)),
    d(i, j, k) = sum_{t = k - w/2}^{k + w/2} |s_phy - s_sim| / w.

    Both sums have one term more than they are divided by, as in the paper; this is a constant factor. Here they are
    one sum: sample t is in `weights[t]` windows.

    Args:
        physical: (trials, samples, sensors) inputs of the controller, in [-1, 1]; at least header + 1 samples.
        simulated: (..., trials, samples, sensors).
        header: h, samples.
        window: w, samples, even.

    Returns:
        (...): not finite where the simulation diverged.
    """
    weights = window_weights(header, window)
    n = header + 1
    difference = np.abs(np.asarray(physical, float)[:, :n] - np.asarray(simulated, float)[..., :n, :])
    trials, sensors = difference.shape[-3], difference.shape[-1]
    return np.einsum("...itj,t->...", difference, weights) / (trials * sensors * (header - window) * window)


def window_weights(header: int, window: int) -> np.ndarray:
    """Number of windows that contain each sample, (header + 1,)."""
    middles = np.arange(window // 2, header - window // 2 + 1)
    t = np.arange(header + 1)[:, None]
    return np.sum(np.abs(t - middles) <= window // 2, axis=1).astype(float)


def distance_error(physical: np.ndarray, simulated: np.ndarray) -> np.ndarray:
    """Equation 1: mean absolute difference of distances.

    Args:
        physical: (trials,) m.
        simulated: (..., trials) m.

    Returns:
        (...) m.
    """
    return np.mean(np.abs(np.asarray(physical, float) - np.asarray(simulated, float)), axis=-1)
