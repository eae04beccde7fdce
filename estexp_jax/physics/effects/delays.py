"""Delays and lags: how short ones can be told, and how MuJoCo holds them."""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np

from estexp_jax.physics.model.robot import Robot

_ROUNDING = 1e-6
"""Part of a step by which a delay may differ from whole steps and still be some."""
_HOLD, _LINEAR = 0, 1
"""MuJoCo's numbers of the ways to read between two samples."""
_SEVERAL = 2.0
"""Steps, at least, of a lag after which its state at the beginning of a step says what its motor does."""
_FILTERS = (mujoco.mjtDyn.mjDYN_FILTEREXACT, mujoco.mjtDyn.mjDYN_FILTER)


def is_longer_than_step(robot: Robot, seconds: float) -> bool:
    """Whether a time is longer than a physics step of the model.

    An integrator of first order acts like a delay of half a step, so that shorter ones cannot be told from it.
    """
    return bool(seconds > robot.model.opt.timestep)


def delay_refusal(robot: Robot, seconds: float) -> str:
    """Why MuJoCo cannot hold a delay; empty where it can."""
    short = 0.0 < seconds < (1.0 - _ROUNDING) * robot.model.opt.timestep
    return "it is shorter than a step, and MuJoCo's delays are not" if short else ""


def add_delay(spec: mujoco.MjSpec, element: Any, seconds: float) -> None:
    """Let an actuator obey, or a sensor read, later by a step or more, exactly at the description's step.

    Whole steps n are held as (n - 1/2) h: at n h, rounding decides between n and n + 1. A part of a step is the mean of
    two commands, which is what reaches a motor during a step in which its command changes. RK4 reads four times a step,
    on average half a step after its beginning, so that there the delay is half a step longer.

    Source: MuJoCo documentation, "Delays".
    """
    step = float(spec.option.timestep)
    total = (_delay_in_force(element, step) + seconds) / step
    whole = round(total)
    if whole < 1:
        return
    if isinstance(element, mujoco.MjsActuator) and _in_stages(spec):
        element.delay, element.nsample, element.interp = (total + 0.5) * step, math.ceil(total + 0.5) + 1, _LINEAR
    elif abs(total - whole) <= _ROUNDING * total:
        element.delay, element.nsample, element.interp = (whole - 0.5) * step, whole, _HOLD
    else:
        element.delay, element.nsample, element.interp = total * step, math.ceil(total) + 1, _LINEAR


def _in_stages(spec: mujoco.MjSpec) -> bool:
    return int(spec.option.integrator) == int(mujoco.mjtIntegrator.mjINT_RK4)


def _delay_in_force(element: Any, step: float) -> float:
    """By how much an element is late already, s: held samples are late by whole steps."""
    if element.nsample <= 0:
        return 0.0
    if int(element.interp) != _HOLD:
        return float(element.delay)
    return step * max(min(math.ceil(element.delay / step - _ROUNDING), element.nsample), 1)


def add_lag(spec: mujoco.MjSpec, actuator: Any, tau: float) -> None:
    """Let an actuator follow its command with a lag of first order; see `lag_refusal`.

    MuJoCo's filter shows its motor the state at the beginning of a step of length h, which is late by h / (1 - e) where
    e = exp(-h / t), or with `actearly` at its end, late by h e / (1 - e). Its time constant t is such that this is tau:
    a lag tau du/dt = command - u is late by tau, whatever the step. Of two lags one behind the other, the sum is what
    is late as much. Under RK4 the exact filter is too slow, so that the filter is integrated there.
    """
    if tau <= 0.0:
        return
    step = float(spec.option.timestep)
    if actuator.dyntype in _FILTERS:
        actuator.dynprm = np.array([actuator.dynprm[0] + tau, *actuator.dynprm[1:]])
        return
    if _in_stages(spec):
        actuator.dyntype, time_constant = mujoco.mjtDyn.mjDYN_FILTER, tau
    elif tau > _SEVERAL * step:
        actuator.dyntype, time_constant = mujoco.mjtDyn.mjDYN_FILTEREXACT, -step / math.log1p(-step / tau)
    else:
        actuator.dyntype, time_constant = mujoco.mjtDyn.mjDYN_FILTEREXACT, step / math.log1p(step / tau)
        actuator.actearly = True
    actuator.dynprm, actuator.actdim = np.array([time_constant, *[0.0] * 9]), 1


def lag_refusal(robot: Robot, actuator: int) -> str:
    """Why an actuator cannot be given a lag of its command; empty where it can."""
    dynamics = int(robot.model.actuator_dyntype[actuator])
    plain = (int(mujoco.mjtDyn.mjDYN_NONE), *map(int, _FILTERS))
    return "" if dynamics in plain else "the actuator has dynamics of its own, and MuJoCo gives each but one"
