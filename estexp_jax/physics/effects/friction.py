"""What kinds of friction have in common: how recordings tell them apart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from estexp_jax.physics.recording import Recording

_ONE_WAY, _AT_ONCE = 0.02, 0.011
"""An asymmetry, and a speed of onset (rad/s), that are at most this where anyone would speak of plain friction."""
_MOTOR_OFF = "Record a motion with the motor off: friction stays, back-EMF and load-dependent losses vanish."
_BOTH_SPEEDS = (
    "Record slow and fast motions of the same path: viscous losses grow with speed, Coulomb friction does not."
)


def friction_advice(recordings: Sequence[Recording]) -> tuple[str, ...]:
    """What to record next to tell kinds of friction from each other."""
    always_on = all(np.all(r.enable > 0.0) for r in recordings)
    return (_MOTOR_OFF, _BOTH_SPEEDS) if always_on else (_BOTH_SPEEDS,)


def reported_shape(values: Mapping[str, float], amount: str) -> dict[str, float]:
    """The values that friction is reported with: its amount, with its asymmetry and its onset where it has any."""
    reported = {amount: values[amount]}
    if abs(values.get("a", 0.0)) > _ONE_WAY:
        reported["a"] = values["a"]
    if values.get("w_0", 0.0) > _AT_ONCE:
        reported["w_0"] = values["w_0"]
    return reported


def shape_in_words(values: Mapping[str, float]) -> str:
    """What follows a sentence on friction that is asymmetric or sets in gradually; nothing for plain friction."""
    said = ""
    if a := values.get("a", 0.0):
        more, less = ("forwards", "backwards") if a > 0.0 else ("backwards", "forwards")
        said += f", {100 * abs(a):.3g} % more {more} and as much less {less}"
    if w_0 := values.get("w_0", 0.0):
        said += f", setting in gradually up to some {w_0:.3g} rad/s"
    return said


def shape_in_equation(values: Mapping[str, float], amount: str, speed: str) -> str:
    """The equation of friction with such a shape.

    Args:
        values: of it.
        amount: the name of its first parameter.
        speed: how its torque depends on speed without one, `w` or `sign(w)`.
    """
    if values.get("w_0", 0.0):
        speed = "tanh(w / w_0)"
    return f"tau = -{amount} {'(1 + a sign(w)) ' if values.get('a', 0.0) else ''}{speed}"
