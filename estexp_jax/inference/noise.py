"""How large a reading's noise is, from the recording alone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from estexp_jax.inference.channels import Channels, spans
from estexp_jax.physics.recording import Recording


def noise_deviation(samples: np.ndarray) -> float:
    """Standard deviation of the noise in a slowly changing signal, in its unit; NaN for fewer than five samples.

    Third differences remove any locally quadratic motion; of white noise of deviation s they leave sqrt(20) s.
    Their median size counts, so that jolts do not. A quantised signal at rest shows no differences at all, so the
    deviation is at least that of its step, step / sqrt(12).

    Args:
        samples: (rows,), NaN where there is no sample.
    """
    y = samples[np.isfinite(samples)]
    if len(y) < 5:
        return float("nan")
    spread = float(np.median(np.abs(np.diff(y, 3)))) / 0.6745 / np.sqrt(20.0)
    return max(spread, _quantum(y) / np.sqrt(12.0))


def noise_floor(channels: Channels, recordings: Sequence[Recording]) -> float:
    """The error that noise alone gives a perfect simulator, in the unit of `accuracy.nrmse`; 0 for no recording."""
    shares = []
    for recording in recordings:
        table, span = channels.recorded(recording), spans(channels, recording)
        shares += [noise_deviation(table[:, c]) / span[c] for c in range(table.shape[1]) if np.isfinite(span[c])]
    found = np.array([s for s in shares if np.isfinite(s)])
    return float(np.sqrt(np.mean(found**2))) if found.size else 0.0


def _quantum(y: np.ndarray) -> float:
    """The smallest step between neighbouring values, where few distinct values recur; else 0."""
    values = np.unique(y)
    if len(values) < 2 or len(values) > 0.5 * len(y):
        return 0.0
    return float(np.median(np.diff(values)))
