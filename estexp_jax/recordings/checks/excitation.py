"""Which common effects recordings can distinguish, from how the joints move."""

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
"""Groups of effects that need a certain motion to be distinguished: the consequence without it, and what to record."""

_SPREAD, _REVERSALS, _SUDDEN, _SOON = 3.0, 4, 0.1, 0.05
_WIDE = {"angle": 0.5, "length": 0.05}


def sufficient_excitation(
    kind: str, time: np.ndarray, values: np.ndarray, clock: np.ndarray, command: np.ndarray | None
) -> dict[str, bool | None]:
    """Which groups of `SUSPECTS` one joint's motion in one recording can distinguish.

    Args:
        kind: `angle` (rad) or `length` (m).
        time: (n,) of the samples, s.
        values: (n,) position of the joint.
        clock: (rows,) times of the command, s.
        command: (rows,) of the actuator that drives it; None: not actuated, so delays cannot be assessed.
    """
    speeds = np.abs(signals.speed(time, values))
    moving = speeds[speeds > 0.05 * float(speeds.max())] if speeds.max() > 0.0 else speeds
    slow, fast = np.percentile(moving, [20, 95])
    span = float(np.ptp(values))
    changes_quickly = None
    if command is not None:
        ahead = np.minimum(np.searchsorted(clock, clock + _SOON), len(clock) - 1)
        changes_quickly = bool(np.abs(command[ahead] - command).max() > _SUDDEN * float(np.ptp(command)) > 0.0)
    return {
        "friction_laws": bool(fast > _SPREAD * slow),
        "reversals": signals.turns(values, max(0.05 * span, 4.0 * signals.encoder_step(values))) >= _REVERSALS,
        "load": span >= _WIDE[kind],
        "delay": changes_quickly,
    }


def missing(inspections: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """What to record in addition, so that the groups of `SUSPECTS` can be distinguished.

    Args:
        inspections: the result of `judge` for each recording of one robot.
    """
    for name in inspections[0]["joints"]:
        per_recording = [one["joints"][name] for one in inspections]
        if not any(joint["columns"] for joint in per_recording):
            yield f"{name}: nothing tells its motion; map an encoder, or log qpos.{name}"
        elif not any(joint["excited"] for joint in per_recording):
            yield f"{name}: never moves, so nothing can be said of it; record motions of it"
        else:
            for suspect, (lack, remedy) in SUSPECTS.items():
                verdicts = [joint["tells"][suspect] for joint in per_recording if joint["tells"]]
                if any(value is False for value in verdicts) and not any(verdicts):
                    yield f"{name}: {lack}; {remedy}"
    if len(inspections) == 1:
        yield "one recording only: its last 30 % becomes the test; a second one, of another motion, proves more"
