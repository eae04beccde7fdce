"""Which of the usual suspects recordings can tell apart, by how the joints move in them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from estexp_jax.recordings.checks import signals

SUSPECTS: Mapping[str, tuple[str, str]] = {
    "friction_laws": (
        "no recording moves it both slowly and fast, so dry and viscous friction look alike",
        "record slow ramps and fast swings",
    ),
    "reversals": (
        "it hardly turns round, so backlash, hysteresis and a zero offset look alike",
        "record motions that reverse some ten times",
    ),
    "load": (
        "it stays in a narrow range, so weight, springs and offsets look alike",
        "record motions over half a radian (5 cm) and more",
    ),
    "delay": (
        "its command never changes quickly, so delay, lag, inertia and friction look alike",
        "record some steps or fast sweeps",
    ),
}
"""What a motion must have to tell effects apart: what is the matter without it, and what to record."""

_SPREAD, _REVERSALS, _SUDDEN, _SOON = 3.0, 4, 0.1, 0.05
_WIDE = {"angle": 0.5, "length": 0.05}


def sufficient_excitation(
    kind: str, time: np.ndarray, values: np.ndarray, clock: np.ndarray, command: np.ndarray | None
) -> dict[str, bool | None]:
    """Which suspects one joint's motion in one recording can tell apart, by the names in `SUSPECTS`.

    Args:
        kind: `angle` (rad) or `length` (m).
        time: (n,) of the samples, s.
        values: (n,) position of the joint.
        clock: (rows,) of the command, s.
        command: (rows,) of the actuator that drives it; None: none does, so nothing can be said of delays.
    """
    speeds = np.abs(signals.speed(time, values))
    moving = speeds[speeds > 0.05 * float(speeds.max())] if speeds.max() > 0.0 else speeds
    slow, fast = np.percentile(moving, [20, 95])
    span = float(np.ptp(values))
    sudden = None
    if command is not None:
        ahead = np.minimum(np.searchsorted(clock, clock + _SOON), len(clock) - 1)
        sudden = bool(np.abs(command[ahead] - command).max() > _SUDDEN * float(np.ptp(command)) > 0.0)
    return {
        "friction_laws": bool(fast > _SPREAD * slow),
        "reversals": signals.turns(values, max(0.05 * span, 4.0 * signals.encoder_step(values))) >= _REVERSALS,
        "load": span >= _WIDE[kind],
        "delay": sudden,
    }


def missing(judged: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """What to record besides, so that the usual suspects can be told apart.

    Args:
        judged: what `judge` told of each recording of one robot.
    """
    for name in judged[0]["joints"]:
        found = [one["joints"][name] for one in judged]
        if not any(joint["columns"] for joint in found):
            yield f"{name}: nothing tells its motion; map an encoder, or log qpos.{name}"
        elif not any(joint["excited"] for joint in found):
            yield f"{name}: never moves, so nothing can be said of it; record motions of it"
        else:
            for suspect, (lack, remedy) in SUSPECTS.items():
                told = [joint["tells"][suspect] for joint in found if joint["tells"]]
                if any(value is False for value in told) and not any(told):
                    yield f"{name}: {lack}; {remedy}"
    if len(judged) == 1:
        yield "one recording only: its last 30 % becomes the test; a second one, of another motion, proves more"
