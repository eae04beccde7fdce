"""Conversion of a robot's own recording of a trial to the control steps of its controller.

Robots' clocks jitter, drift, and run at other rates. At control step k, that is at t = k dt after the first row:

- angles and positions are interpolated between the samples around t; holding them would add a delay of up to a row;
- touch is that of the sample nearest to t, as +1/-1;
- commands are those valid in the middle of the step, at t + dt / 2, so that a slightly delayed row still counts for its
  own step.

Then the readings that the network received are identified. In closed loop it gives the recorded commands for the
recorded readings. If the robot has played the predicted commands instead, these are the predicted readings. If neither
holds, the recording cannot be replayed and is rejected.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, final

import numpy as np

from estexp_jax.errors import InputError
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.model.travel import root_position_map
from estexp_jax.physics.recording import Recording
from estexp_jax.recovery.control.trial import AXES, Controller, Trial

_MISSING_SHARE = 0.02
"""Share of a trial's time, in addition to one step, that may be missing at its end because clocks drift."""
_LONGEST_GAP = 5.0
"""Control steps without a sample from which on a gap is reported; where readings are compared, it is rejected."""
_LONGEST_HOLD = 10.0
"""Control steps for which the first and the last measured position are extrapolated."""
_COMMAND_TOLERANCE = 0.2
"""Median difference, in units of the command's scale, above which recorded commands are not those of a controller."""


@final
@dataclass(frozen=True, eq=False)
class ExpectedTrial:
    """The trial that a recording should contain.

    Attributes:
        controller: that should have driven the robot.
        predicted: the trial that the simulator, as diagnosed so far, predicts.
        axis: along which the distance counts.
        compared: control steps from the beginning whose readings are compared.
        needs_distance: whether the distance must be known.
    """

    controller: Controller
    predicted: Trial
    axis: str
    compared: int
    needs_distance: bool = False


class LoggedTrial(NamedTuple):
    """A trial, and remarks on its recording."""

    trial: Trial
    notes: tuple[str, ...]


def trial_of_recording(robot: Robot, recording: Recording, expected: ExpectedTrial, where: str) -> LoggedTrial:
    """The trial in a recording.

    Args:
        robot: the nominal robot.
        recording: its first row is the first control step, at rest with the motors at home; it may continue after the
            trial.
        expected: the trial that it should contain.
        where: the file, for messages.

    Raises:
        InputError: it is too short; an input of the controller has no samples where they are compared; the position is
            needed and missing; or the commands are not those of the controller.
    """
    controller, time = expected.controller, recording.time - recording.time[0]
    period, grid = controller.control_step, controller.control_step * np.arange(controller.steps)
    if time[-1] < (1.0 - _MISSING_SHARE) * grid[-1] - 1.5 * period:
        what = f"lasts {time[-1]:.3g} s, a trial {grid[-1] + period:.3g} s"
        right = f"{controller.steps} rows, one every {period:g} s; or a run with fewer --steps"
        raise InputError(what, where=f"{where}, column 'time'", right=right)
    readings, notes = _readings(recording, time, grid, expected, where)
    last = np.searchsorted(time, grid + 0.5 * period, side="right") - 1
    position = _position(robot, recording, time, grid, period)
    trial = Trial(grid, readings, recording.ctrl[last], position)
    row = float(np.median(np.diff(time)))
    if row > 1.2 * period:
        notes += (f"rows are {row:.3g} s apart, control steps {period:g} s",)
    trial = _with_network_readings(robot, trial, expected, where)
    return LoggedTrial(trial, (*notes, *_distance_notes(robot, trial, expected, where)))


def _readings(
    recording: Recording, time: np.ndarray, grid: np.ndarray, expected: ExpectedTrial, where: str
) -> tuple[np.ndarray, tuple[str, ...]]:
    face, period = expected.controller.interface, expected.controller.control_step
    columns, notes = [], []
    for name, touch, values in zip(face.names, face.is_touch, recording.sensor[:, face.columns].T, strict=True):
        measured = np.isfinite(values)
        column = f"{where}, column 'sensor.{name}'"
        if not measured.any():
            right = f"the controller reads {', '.join(face.names)}; for a lost sensor, record the value given for it"
            raise InputError("has no sample", where=column, right=right)
        at, values = time[measured], values[measured]
        edges = np.concatenate([[0.0], at[at <= grid[-1]], [grid[-1]]])
        wide = np.flatnonzero(np.diff(edges) > (_LONGEST_GAP + 0.5) * period)
        if len(wide):
            start, length = edges[wide[0]], float(np.diff(edges)[wide[0]])
            what = f"no sample for {length:.3g} s, {start:.3g} s after the first row"
            if start < expected.compared * period:
                right = f"in the first {expected.compared * period:.3g} s there have to be samples: they are compared"
                raise InputError(what, where=column, right=right)
            notes.append(f"sensor.{name}: {what}" + (f", and {len(wide) - 1} more gaps" if len(wide) > 1 else ""))
        columns.append(_nearest(grid, at, np.where(values > 0.0, 1.0, -1.0)) if touch else np.interp(grid, at, values))
    return np.stack(columns, axis=1), tuple(notes)


def _nearest(grid: np.ndarray, at: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values (samples,) at times `at`, resampled to the nearest of each time of a grid."""
    return values[np.searchsorted(0.5 * (at[1:] + at[:-1]), grid)]


def _position(robot: Robot, recording: Recording, time: np.ndarray, grid: np.ndarray, period: float) -> np.ndarray:
    """The root's position (steps, 3), m; NaN where it is not recorded."""
    matrix, offset = root_position_map(robot)
    position = np.tile(offset, (len(grid), 1))
    for component, row in enumerate(matrix):
        for coordinate in np.flatnonzero(row):
            values = recording.qpos[:, coordinate]
            measured = np.isfinite(values)
            found = np.full(len(grid), np.nan)
            if measured.any():
                at = time[measured]
                found = np.interp(grid, at, values[measured])
                # The last row of a slow clock may lie after the trial's end, that of a fast one before it.
                reach = _LONGEST_HOLD * period
                found[(grid < at[0] - reach) | (grid > at[-1] + reach)] = np.nan
            position[:, component] += row[coordinate] * found
    return position


def _distance_notes(robot: Robot, trial: Trial, expected: ExpectedTrial, where: str) -> tuple[str, ...]:
    """A remark if the distance is unknown.

    Raises:
        InputError: it must be known.
    """
    if np.isfinite(trial.distance(expected.axis)):
        return ()
    names = " and ".join(_columns(robot, AXES[expected.axis][0]))
    if expected.needs_distance:
        what = "the distance is not known, and --metric distance compares it"
        raise InputError(what, where=where, right=f"at least the first and the last value of {names}, m")
    return (f"the distance is not known; the first and the last value of {names} would tell",)


def _columns(robot: Robot, component: int) -> list[str]:
    """The columns of a recording that determine one component of the root's position."""
    addresses = robot.model.jnt_qposadr.tolist()
    found = []
    for coordinate in np.flatnonzero(root_position_map(robot)[0][component]).tolist():
        joint = max(j for j, address in enumerate(addresses) if address <= coordinate)
        scalar = joint in robot.scalar_joints
        name = robot.names("joint")[joint]
        found.append(f"qpos.{name}" if scalar else f"qpos.{name}.{coordinate - addresses[joint]}")
    return found


def _with_network_readings(robot: Robot, trial: Trial, expected: ExpectedTrial, where: str) -> Trial:
    """The trial with the readings that its network received.

    Raises:
        InputError: the commands are neither the controller's nor the predicted ones.
    """
    controller, n = expected.controller, min(expected.compared, len(trial.time))
    hidden, given = controller.rest(), np.zeros((n, controller.interface.n_outputs))
    for row in range(n):
        hidden, given[row] = controller.respond(hidden, trial.readings[row])
    # Medians of each motor, because a reading that is shifted by a row also shifts a jump of the command.
    closed, played = (
        np.median(np.abs(commands[:n] - trial.commands[:n]) / controller.interface.ctrl_scale, axis=0)
        for commands in (given, expected.predicted.commands)
    )
    if played.max() < min(closed.max(), _COMMAND_TOLERANCE):
        return Trial(trial.time, trial.readings, trial.commands, trial.position, expected.predicted.readings)
    if closed.max() <= _COMMAND_TOLERANCE:
        return trial
    worst = int(np.argmax(closed))
    off = float(closed[worst] * controller.interface.ctrl_scale[worst])
    column = f"{where}, column 'ctrl.{robot.names('actuator')[worst]}'"
    what = f"commands are off by {off:.3g} from those of the controller for these readings (median of {n} steps)"
    right = (
        "drive the robot by the controller's file, row by row, or play the commands' file; check order, signs, units"
    )
    raise InputError(what, where=column, right=right)
