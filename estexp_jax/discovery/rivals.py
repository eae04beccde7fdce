"""The explanation beside its rivals: errors of each on training recordings, and on test recordings none has seen."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import mujoco
import numpy as np

from estexp_jax.discovery.black_box import BlackBox, trained
from estexp_jax.discovery.c_replay import simulated_with
from estexp_jax.discovery.diagnosis import Case, ExplainConfig
from estexp_jax.discovery.export import explained_spec
from estexp_jax.discovery.force_residual import ForceResidual, force_residuals
from estexp_jax.discovery.intervals import gain_interval, ratio_interval
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.shown import Shown
from estexp_jax.discovery.slopes import Fit
from estexp_jax.estimation.accuracy import gain
from estexp_jax.estimation.noise import noise_floor

ROLES = ("train", "test")
RIVALS = ("nominal", "parameters_only", "black_box", "placebo", "explained")
"""All that are compared, in the order in which they are told."""


_WORSE = 1.2
"""Squared error over the nominal simulator's from which an explanation counts as refuted ..."""
_BETTER = 0.5
"""... and up to which values that explain nothing by themselves are kept: what they gain less on the motions they were
fitted to, others may take back."""

Base = tuple[Sequence[mujoco.MjModel], Sequence[ForceResidual]]
"""Each recording's robot in the C engine, and what its joints lack in the training recordings."""


def base_of(case: Case, problem: Problem, fitted: Fit) -> Base:
    """The robot under a fit that MJCF can say: what a black box and the regime stand on."""
    changes, known = fitted.hypothesis.changes(fitted.vector), {}
    for robot in case.robots:
        if id(robot) not in known:
            known[id(robot)] = explained_spec(robot, changes).compile()
    models = [known[id(robot)] for robot in case.robots]
    return models, force_residuals(problem, models, case.indices("train"))


def black_box_errors(case: Case, config: ExplainConfig, problem: Problem, bases: Sequence[Base]) -> dict[str, float]:
    """Errors of a black box on training and test recordings; {} where there is no joint for it to act on.

    Of several robots that the network may correct, the one that predicts the fitted windows best counts. Refitted
    parameters are not always the better start: motors bent to stand in for friction spoil readings of their torque,
    which no force on a joint mends.

    Args:
        case: what is explained.
        config: how.
        problem: the comparison.
        bases: the robots.
    """
    train, test = (problem.windows_of(case.indices(role)) for role in ROLES)
    exact = problem.exact()

    def error(models: Sequence[mujoco.MjModel], network: BlackBox, windows: np.ndarray) -> float:
        return exact.recorded.error_of(simulated_with(exact, models, network, windows), windows)

    found = []
    for models, seen in bases:
        network = trained(models[0], seen, min(config.window, 2.0), config.seed)
        if network is not None:
            found.append((error(models, network, exact.fitted), models, network))
    if not found:
        return {}
    fitted, models, network = min(found, key=lambda each: each[0])
    whole = fitted if np.array_equal(exact.fitted, train) else error(models, network, train)
    return {"train": whole, "test": error(models, network, test)}


def refuted(case: Case, config: ExplainConfig, shown: Shown, role: str) -> bool:
    """Whether recordings of a role are plainly predicted worse by the explanation than by the nominal simulator.

    Test recordings choose nothing, so with these the verdict stays what it is; but it has to be said.
    """
    windows = shown.problem.windows_of(case.indices(role))
    if not np.isfinite(shown.error("explained", windows)):
        return np.isfinite(shown.error("nominal", windows))
    nominal, explained = (shown.costs(name, windows) for name in ("nominal", "explained"))
    return ratio_interval(explained, nominal, config.seed)[0] > _WORSE


def better(case: Case, config: ExplainConfig, shown: Shown) -> bool:
    """Whether training recordings are predicted so much better than by the nominal simulator that others will be."""
    windows = shown.problem.windows_of(case.indices("train"))
    nominal, explained = (shown.costs(name, windows) for name in ("nominal", "explained"))
    return bool(ratio_interval(explained, nominal, config.seed)[1] < _BETTER)


def fit_entry(
    case: Case, config: ExplainConfig, shown: Shown, names: Sequence[str], black_box: Mapping[str, float]
) -> dict[str, Any]:
    """Errors of nominal, rivals and explanation on training and test recordings, and the gain on the test recordings.

    Args:
        case: what was explained.
        config: how.
        shown: the simulators beside the recordings.
        names: those of `RIVALS` that there are.
        black_box: errors of `black_box_errors`.
    """
    problem = shown.problem
    windows = {role: problem.windows_of(case.indices(role)) for role in ROLES}
    floors = {role: noise_floor(problem.channels, [case.recordings[i] for i in case.indices(role)]) for role in ROLES}
    errors = {name: {role: shown.error(name, w) for role, w in windows.items()} for name in names}
    errors["black_box"] = dict(black_box)
    costs = [shown.costs(name, windows["test"]) for name in ("nominal", "explained")]
    low, high = gain_interval(costs[0], costs[1], floors["test"], config.seed)
    value = gain(errors["explained"]["test"], errors["nominal"]["test"], floors["test"])
    return {
        "metric": "nrmse",
        "window_s": config.window,
        "noise_floor": floors,
        **{name: errors.get(name, {}) for name in RIVALS},
        "gain": {"value": value, "low": float(low), "high": float(high)},
    }
