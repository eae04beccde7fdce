"""What values of the model, and claims made before, would explain if they were fitted: taken out of residuals.

Near one point, values that are off by d add J d to the residuals r. Fitted, under a normal prior with precisions P,
they leave

    min over d of |r + J d|^2 + d' P d  =  r' (I + J P^-1 J')^-1 r,

a weighing of the residuals that is found once and serves every hypothesis: each is judged as if all those values had
been fitted beside it, while only its own parameters move.

Source: Rasmussen and Williams, Gaussian Processes for Machine Learning (2006), section 2.7 (parameters integrated out).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from estexp_jax.discovery.uncertain_starts import directions, whitened


@final
@dataclass(frozen=True, eq=False)
class Slack:
    """What is taken out of residuals of some windows; n values may be off.

    Attributes:
        basis: (1, samples, n) directions, `kept`: (1, n) what remains along them.
        shift: (samples,) what the values at the point where they were derived explain already.
        answer: (n, samples) the values' best offsets from the prior's centre for residuals, less `shift`, with its sign
            turned.
    """

    basis: np.ndarray
    kept: np.ndarray
    shift: np.ndarray
    answer: np.ndarray

    def taken_out(self, residuals: np.ndarray) -> np.ndarray:
        """Residuals (members, windows, samples) whose squares sum to what is left once the values are fitted."""
        flat = residuals.reshape(len(residuals), 1, -1) - self.shift.astype(np.float32)
        return whitened(flat, self.basis, self.kept).reshape(residuals.shape)

    def offsets(self, residuals: np.ndarray) -> np.ndarray:
        """The values' offsets (members, n) from the prior's centre that fit residuals (members, windows, samples)."""
        return -(residuals.reshape(len(residuals), -1) - self.shift) @ self.answer.T


def slack_of(derivative: np.ndarray, precision: np.ndarray, offset: np.ndarray) -> Slack:
    """The slack that values leave.

    Args:
        derivative: (windows, samples, n) of the residuals by the values.
        precision: (n,) of the prior, in the unit in which residuals' squares are costs.
        offset: (n,) of the values from the prior's centre, at the point where they were derived.
    """
    samples = int(np.prod(derivative.shape[:-1]))  # not -1: where a manifest tells every value, n is 0
    j = derivative.reshape(samples, derivative.shape[-1]).astype(np.float64)
    basis, kept = directions((j / np.sqrt(precision))[None])
    return Slack(basis, kept, j @ offset, np.linalg.solve(j.T @ j + np.diag(precision), j.T))
