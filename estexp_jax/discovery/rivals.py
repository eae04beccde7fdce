"""The explanation beside its rivals: errors of each on training recordings, and on test recordings none has seen."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from estexp_jax.discovery.diagnosis import Case, ExplainConfig
from estexp_jax.discovery.fitting import Fit
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.uncertainty import gain_interval
from estexp_jax.inference.accuracy import gain
from estexp_jax.inference.noise import noise_floor

ROLES = ("train", "test")
RIVALS = ("nominal", "parameters_only", "black_box", "placebo", "explained")
"""All that are compared, in the order in which they are told."""


def fit_entry(case: Case, config: ExplainConfig, problem: Problem, fits: Mapping[str, Fit]) -> dict[str, Any]:
    """Errors of nominal, rivals and explanation on training and test recordings, and the gain on the test recordings.

    The nominal simulator runs at its own step, the others at the finer one.

    Args:
        case: what was explained.
        config: how.
        problem: the comparison.
        fits: those of `RIVALS` that there are.
    """
    windows = {role: problem.windows_of(case.indices(role)) for role in ROLES}
    floors = {role: noise_floor(problem.channels, [case.recordings[i] for i in case.indices(role)]) for role in ROLES}
    own, exact = replace(problem, correction=None), problem.exact()
    at = {name: own if name == "nominal" else exact for name in fits}
    errors = {name: {role: at[name].error(f.member, w) for role, w in windows.items()} for name, f in fits.items()}
    shares = [at[n].shares(fits[n].member, windows["test"]) for n in ("nominal", "explained")]
    costs = [np.nanmean(s, axis=(1, 2)) for s in shares]
    low, high = gain_interval(costs[0], costs[1], floors["test"], config.seed)
    value = gain(errors["explained"]["test"], errors["nominal"]["test"], floors["test"])
    return {
        "metric": "nrmse",
        "window_s": config.window,
        "noise_floor": floors,
        **{name: errors.get(name, {}) for name in RIVALS},
        "gain": {"value": value, "low": float(low), "high": float(high)},
    }
