"""Whether a trial's angles have the right unit and signs, each in its own column.

From rest a robot starts as its simulator predicts, damaged or not, for some tenths of a second: the joints that are
well do. So the first readings are compared with the predicted ones, as they are, turned round, and exchanged in pairs.
"""

from __future__ import annotations

import numpy as np

from estexp_jax.errors import InputError
from estexp_jax.recovery.control.trial import Controller, Trial

_TURNS, _DEGREES = 1.25, 20.0
"""Turns from home, and multiple of what is predicted, beyond which angles are in degrees (57): wheels are predicted."""
_FAR_BETTER = 0.1
"""Share of the squared distance from the prediction to which another reading of the columns must bring it. Measured: so
it tells all signs and exchanges of a sound quadruped, and 4 % of damaged ones', most of them of tied motors, too."""
_MOVES = 0.05
"""Root mean square that is predicted from which on an angle's sign is told, rad or m."""


def plausibility_notes(
    controller: Controller, trial: Trial, predicted: Trial, compared: int, where: str
) -> tuple[str, ...]:
    """Remarks on angles that seem to have a wrong sign, or to be in each other's columns; a damage may do that, too.

    Args:
        controller: that drove the robot.
        trial: what was recorded.
        predicted: what the simulator, as diagnosed so far, predicts.
        compared: control steps from the beginning that are compared.
        where: the file, for messages.

    Raises:
        InputError: angles are not in radians.
    """
    face = controller.interface
    angles = np.flatnonzero(~face.is_touch)
    column = f"{where}, column 'sensor.{{}}'"
    reach, predicted_reach = (
        np.abs(t.readings[:, angles] - face.centre[angles]).max(axis=0) for t in (trial, predicted)
    )
    turns = np.where(reach > _DEGREES * predicted_reach, reach, 0.0) / (2.0 * np.pi)
    if turns.max(initial=0.0) > _TURNS:
        worst = int(np.argmax(turns))
        what = f"goes {2.0 * np.pi * turns[worst]:.3g} from its home, {turns[worst]:.2g} turns if these are radians"
        raise InputError(what, where=column.format(face.names[angles[worst]]), right="log angles in radians")
    found, expected = (t.readings[:compared, angles] - face.centre[angles] for t in (trial, predicted))
    distance = _squares(found, expected)
    moves = np.mean(expected**2, axis=0) > _MOVES**2
    turned = np.mean((found + expected) ** 2, axis=0)
    notes = [
        f"sensor.{face.names[angles[k]]} runs against what is predicted: see that its sign is right"
        for k in np.flatnonzero(moves & (turned < _FAR_BETTER * np.diag(distance)))
    ]
    for a in np.flatnonzero(moves):
        for b in np.flatnonzero(moves[: int(a)]):
            if distance[a, b] + distance[b, a] < _FAR_BETTER * (distance[a, a] + distance[b, b]):
                one, other = (face.names[angles[k]] for k in (b, a))
                notes.append(
                    f"sensor.{one} and sensor.{other} move as is predicted of each other: see that none is exchanged"
                )
    return tuple(notes)


def _squares(found: np.ndarray, expected: np.ndarray) -> np.ndarray:
    """Mean squares (n, n) of differences between each column found and each that is expected, (rows, n) both."""
    return np.mean((found[:, :, None] - expected[:, None, :]) ** 2, axis=0)
