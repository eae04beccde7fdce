"""The explanation beside its rivals: errors of each on training recordings, and on test recordings none has seen."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np

from estexp_jax.discovery.black_box import trained
from estexp_jax.discovery.c_replay import simulated_with
from estexp_jax.discovery.diagnosis import Case, ExplainConfig
from estexp_jax.discovery.export import explained_spec
from estexp_jax.discovery.fitting import Fit
from estexp_jax.discovery.force_residual import ForceResidual
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.uncertainty import gain_interval
from estexp_jax.inference.accuracy import gain
from estexp_jax.inference.noise import noise_floor

ROLES = ("train", "test")
RIVALS = ("nominal", "parameters_only", "black_box", "placebo", "explained")
"""All that are compared, in the order in which they are told."""


def refitted_models(case: Case, own: Fit) -> list[mujoco.MjModel]:
    """Each recording's robot in the C engine, with refitted parameters: what black box and residuals stand on."""
    changes, known = own.hypothesis.changes(own.vector), {}
    for robot in case.robots:
        if id(robot) not in known:
            known[id(robot)] = explained_spec(robot, changes).compile()
    return [known[id(robot)] for robot in case.robots]


def black_box_errors(
    case: Case, config: ExplainConfig, problem: Problem, models: Sequence[mujoco.MjModel], seen: Sequence[ForceResidual]
) -> dict[str, float]:
    """Errors of a black box on training and test recordings; {} where there is no joint for it to act on.

    Args:
        case: what is explained.
        config: how.
        problem: the comparison.
        models: of `refitted_models`.
        seen: the force residual of the training recordings.
    """
    network = trained(models[0], seen, min(config.window, 2.0), config.seed)
    if network is None:
        return {}
    windows = {role: problem.windows_of(case.indices(role)) for role in ROLES}
    exact = problem.exact()
    return {role: exact.error_of(simulated_with(exact, models, network, w), w) for role, w in windows.items()}


def fit_entry(
    case: Case, config: ExplainConfig, problem: Problem, fits: Mapping[str, Fit], black_box: Mapping[str, float]
) -> dict[str, Any]:
    """Errors of nominal, rivals and explanation on training and test recordings, and the gain on the test recordings.

    The nominal simulator runs at its own step, the others at the finer one.

    Args:
        case: what was explained.
        config: how.
        problem: the comparison.
        fits: those of `RIVALS` that there are.
        black_box: errors of `black_box_errors`.
    """
    windows = {role: problem.windows_of(case.indices(role)) for role in ROLES}
    floors = {role: noise_floor(problem.channels, [case.recordings[i] for i in case.indices(role)]) for role in ROLES}
    own, exact = replace(problem, correction=None), problem.exact()
    at = {name: own if name == "nominal" else exact for name in fits}
    errors = {name: {role: at[name].error(f.member, w) for role, w in windows.items()} for name, f in fits.items()}
    errors["black_box"] = dict(black_box)
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
