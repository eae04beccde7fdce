"""How much of what a log's replay misses ordinary physics can explain, all of it at once, and a number beside it.

Friction, damping and inertia of each joint, the strength of each motor and the mass of each body are fitted to the
replayed pieces by Levenberg and Marquardt's method.
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import NamedTuple

import mujoco
import numpy as np

from estexp_jax.estimation.log_replay import LogReplay
from estexp_jax.physics.recording import Recording

_ROUNDS, _DAMPINGS = 4, (1e-4, 1e-3, 1e-2, 1e-1, 1.0)
"""Steps of the fit, and the shares of the mean curvature by which each is damped in trials.

The least holds a value where the log says nothing of it; the larger ones lead out of places where friction at rest
makes the curvature a wrong one.
"""
_MOST = 1.5
"""Largest change of a strength or mass, as a logarithm; of others, in their own scale, a few times that."""
_STEP = 0.05
"""Of a value, in its own scale, for its derivative."""
_SLOW = 5.0
"""Damping that brings a joint to rest within a fifth of a second is the scale of dampings, 1/s."""
_CLOSE = 0.98
"""A step that leaves more than this share of the squared error is the last one."""
_TRIES = 11
"""So often a number is tried at most."""
_ALIKE = 20.0
"""Of so many errors of a piece, at its times and in its joints, each says much the same as the others."""


class NumberFit(NamedTuple):
    """A number of a fault of logging: the error at it, itself, and its deviation."""

    error: float
    value: float
    deviation: float


def fit_physics(replay: LogReplay, recording: Recording) -> float:
    """The error that ordinary physics leaves of a log, as `LogReplay.errors` gives it.

    Args:
        replay: of the log.
        recording: a version of it.
    """
    scales = _scales(replay)
    x, nv = np.zeros(len(scales)), replay.model.nv
    low, high = np.full(len(x), -_MOST), np.full(len(x), _MOST)
    low[:nv], high[: 3 * nv] = 0.0, 20.0

    def at(points: np.ndarray) -> np.ndarray:
        """Residuals (points, n) at values (points, len(x))."""
        models = [_edited(replay.model, p * scales) for p in points]
        left = np.clip(replay.residuals([recording] * len(points), models), -1.0, 1.0)
        return left.reshape(len(points), -1)[:, known]

    known = np.isfinite(replay.residuals([recording])).ravel()
    best = float("inf")
    for _ in range(_ROUNDS):
        here, *moved = at(np.vstack([x, x + _STEP * np.eye(len(x))]))
        best = float(np.mean(here**2))
        derivatives = (np.array(moved) - here).T / _STEP
        curvature = derivatives.T @ derivatives
        stiff, down = np.trace(curvature) / len(x) * np.eye(len(x)), -derivatives.T @ here
        ways = [np.linalg.lstsq(curvature + damping * stiff, down, rcond=None)[0] for damping in _DAMPINGS]
        tried = np.clip(x + np.array(ways), low, high)
        errors = np.mean(at(tried) ** 2, axis=1)
        if not errors.min() < best:
            break
        is_last = errors.min() > _CLOSE * best
        x, best = tried[int(errors.argmin())], float(errors.min())
        if is_last:
            break
    return float(np.sqrt(best))


def fit_number(
    error_at: Callable[[float], float], value: float, step: float, bounds: tuple[float, float], count: int
) -> NumberFit:
    """The number with the least error, by parabolas through three points of its square.

    Args:
        error_at: gives the error at a value.
        value: to begin with.
        step: between the five values that are tried first, since the error may be rough.
        bounds: of the value.
        count: how many errors are in one.
    """
    first = dict.fromkeys(float(np.clip(value + k * step, *bounds)) for k in (-2, -1, 0, 1, 2))
    squares = {v: error_at(v) ** 2 for v in first}
    while len(squares) < _TRIES:
        best = min(squares, key=squares.__getitem__)
        ordered = sorted(squares)
        k = ordered.index(best)
        if k in (0, len(ordered) - 1):
            further = float(np.clip(best + (step if k else -step), *bounds))
            if further in squares:
                break
            squares[further] = error_at(further) ** 2
            continue
        low, high = ordered[k - 1], ordered[k + 1]
        vertex, _ = _parabola(low, best, high, squares)
        if min(abs(vertex - v) for v in (low, best, high)) < 0.1 * step:
            wide = low if best - low > high - best else high
            if abs(wide - best) <= 0.5 * step:
                break
            vertex = 0.5 * (wide + best)
        squares[vertex] = error_at(vertex) ** 2
    best = min(squares, key=squares.__getitem__)
    ordered = sorted(squares)
    k = min(max(ordered.index(best), 1), len(ordered) - 2)
    _, curvature = _parabola(ordered[k - 1], ordered[k], ordered[k + 1], squares)
    deviation = np.sqrt(_ALIKE * squares[best] / (count * curvature)) if curvature > 0.0 else abs(step)
    return NumberFit(float(np.sqrt(squares[best])), best, float(deviation))


def _parabola(a: float, b: float, c: float, squares: dict[float, float]) -> tuple[float, float]:
    """Where a parabola through three points is least, and its leading coefficient; b where it has no least."""
    one, two = (squares[b] - squares[a]) / (b - a), (squares[c] - squares[b]) / (c - b)
    curvature = (two - one) / (c - a)
    return (0.5 * (a + b) - 0.5 * one / curvature if curvature > 0.0 else b), curvature


def _scales(replay: LogReplay) -> np.ndarray:
    """Of frictions, dampings, inertias (nv each), strengths (nactuator) and masses (bodies but the world)."""
    model = replay.model
    inertia = np.maximum(model.dof_M0, 1e-9)
    friction = inertia * _SLOW * replay.spans
    return np.concatenate([friction, _SLOW * inertia, inertia, np.ones(model.nactuator + model.nbody - 1)])


def _edited(model: mujoco.MjModel, amounts: np.ndarray) -> mujoco.MjModel:
    """The model with what `_scales` lists added, or multiplied by its exponential."""
    nv, edited = model.nv, copy.copy(model)
    friction, damping, inertia, strength, mass = np.split(amounts, np.cumsum([nv, nv, nv, model.nactuator]))
    edited.dof_frictionloss[:] = model.dof_frictionloss + friction
    first = (slice(None),) + (0,) * (model.dof_damping.ndim - 1)
    edited.dof_damping[first] = np.maximum(model.dof_damping[first] + damping, 0.0)
    edited.dof_armature[:] = np.maximum(model.dof_armature + inertia, 0.0)
    edited.actuator_gainprm[:] = model.actuator_gainprm * np.exp(strength)[:, None]
    edited.actuator_biasprm[:] = model.actuator_biasprm * np.exp(strength)[:, None]
    edited.body_mass[1:] = model.body_mass[1:] * np.exp(mass)
    edited.body_inertia[1:] = model.body_inertia[1:] * np.exp(mass)[:, None]
    return edited
