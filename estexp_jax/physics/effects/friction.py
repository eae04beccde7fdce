"""What kinds of friction have in common: how recordings tell them apart."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from estexp_jax.physics.recording import Recording

_MOTOR_OFF = "Record a motion with the motor off: friction stays, back-EMF and load-dependent losses vanish."
_BOTH_SPEEDS = (
    "Record slow and fast motions of the same path: viscous losses grow with speed, Coulomb friction does not."
)


def friction_advice(recordings: Sequence[Recording]) -> tuple[str, ...]:
    """What to record next to tell kinds of friction from each other."""
    always_on = all(np.all(r.enable > 0.0) for r in recordings)
    return (_MOTOR_OFF, _BOTH_SPEEDS) if always_on else (_BOTH_SPEEDS,)
