"""Faults of recordings that are found by comparing a motor's command with its joint's motion."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, final

import mujoco
import numpy as np

from estexp_jax.physics.model.actuators import actuator_of_input, gear_of, inputs_of, position_input
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.recordings.checks import signals
from estexp_jax.recordings.checks.faults import FULL_TURNS, Fault
from estexp_jax.recordings.checks.zero_faults import offset_faults

SATURATED = 0.05
"""Share of rows with the command at its limit above which saturation is reported."""
SLOW_RESPONSE = 0.1
"""Delay of a servo above which it is reported, s."""
_DEGREES, _PER_DEGREE = (30.0, 110.0), (1 / 110.0, 1 / 30.0)
_SAME = (0.5, 2.0)
_TICKS = (125.0, 20_000.0)  # from 10 bits a turn to 16


@final
@dataclass(frozen=True)
class Follower:
    """A position servo and the reading of its joint's position.

    Attributes:
        actuator: index.
        name: of the actuator.
        column: our column of the reading.
    """

    actuator: int
    name: str
    column: str


def follower_faults(robot: Robot, recording: Recording, follower: Follower, values: np.ndarray) -> Iterator[Fault]:
    """A reading that does not follow its servo's command: wrong unit, sign or clock, or a stuck sensor.

    Args:
        robot: with the recording's settings applied.
        recording: for its commands.
        follower: servo and reading.
        values: (rows,) the reading, NaN where there is no sample.
    """
    (time, command, reading), name = follows_commands(robot, recording, follower.actuator, values), follower.column
    if len(time) < 20 or float(np.ptp(command)) <= 0.0 or float(np.ptp(reading)) <= 0.0:
        return
    delay, correlation, correlation_without = signals.lag(time, command, reading)
    if correlation > 0.8:
        ratio = float(np.std(reading) / np.std(command))
        yield from _scale_fault(name, follower, ratio)
        joint = robot.joint_of_actuator(follower.actuator)
        if joint is not None and _SAME[0] < ratio < _SAME[1]:
            yield from offset_faults(robot, follower.actuator, joint, name, (time, command, reading))
        # A single swing of another amplitude looks like a delay; only several swings determine one.
        if signals.turns(command, 0.1 * float(np.ptp(command))) < 2:
            delay = 0.0
        smallest = max(0.01, 1.5 * float(np.median(np.diff(time))))
        if delay < -smallest and correlation > max(0.95, correlation_without + 0.002):
            what = f"moves {-delay:.3g} s before its command"
            remedy = "stamp both with one clock, or shift one; if the motor was off, map enable.*"
            yield Fault("ahead", name, f"{what}: their clocks do not agree; {remedy}")
        elif delay > SLOW_RESPONSE and correlation > correlation_without + 0.002:
            what = f"follows its command {delay:.2g} s later"
            yield Fault("late", name, f"{what}: a slow motor, friction, a delay, or two clocks; use one clock for both")
    elif signals.lag(time, -command, reading, max_lag=0.05)[1] > 0.9 and correlation < 0.6:
        yield Fault("sign", name, "moves against its command; if its sign is wrong, give scale = -1.0")
    yield from _stuck_fault(name, time, command, reading)


def follows_commands(
    robot: Robot, recording: Recording, actuator: int, values: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time, commanded and measured position of a servo's joint, over the longest stretch with the motor on.

    Args:
        robot: with the recording's settings.
        recording: its commands.
        actuator: index of the servo.
        values: (rows,) the reading, NaN where there is no sample.
    """
    on = recording.enable[:, actuator] > 0.0
    stretch = max((run for run in signals.runs(on.astype(float), 1) if on[run.start]), key=_length, default=None)
    rows = np.flatnonzero(np.isfinite(values))
    rows = rows[(rows >= stretch.start) & (rows < stretch.stop)] if stretch else rows[:0]
    command = recording.ctrl[rows, inputs_of(robot.model, actuator)[0]] / (gear_of(robot.model, actuator) or 1.0)
    return recording.time[rows], command, values[rows]


def _length(run: signals.Run) -> int:
    return run.length


def _scale_fault(name: str, follower: Follower, ratio: float) -> Iterator[Fault]:
    if _TICKS[0] < ratio < _TICKS[1]:
        what = f"moves {ratio:.4g} times as far as ctrl.{follower.name}: raw encoder ticks?"
        yield Fault("ticks", name, f"{what} Give their scale, such as 2 pi / 4096 = 0.0015339808, and the offset")
    elif _DEGREES[0] < ratio < _DEGREES[1]:
        yield Fault(
            "degrees",
            name,
            f'moves {ratio:.4g} times as far as ctrl.{follower.name}; is it in degrees? Then give unit = "deg"',
        )
    elif _PER_DEGREE[0] < ratio < _PER_DEGREE[1]:
        what = f"moves {1 / ratio:.4g} times as far as {name} follows; is it in degrees?"
        yield Fault("degrees", f"ctrl.{follower.name}", f'{what} Then give unit = "deg"')


def _stuck_fault(name: str, time: np.ndarray, command: np.ndarray, reading: np.ndarray) -> Iterator[Fault]:
    for run in signals.runs(reading, max(20, int(0.02 * len(reading)))):
        # Servos respond late, so commands at the end of the run are ignored.
        length = float(time[run.stop - 1] - time[run.start])
        answered = time[run.start : run.stop] <= time[run.stop - 1] - min(0.5, 0.5 * length)
        commanded_span = float(np.ptp(command[run.start : run.stop][answered]))
        if commanded_span > 0.3 * float(np.ptp(command)) and length > 0.2:
            what = f"stands still from {time[run.start]:.4g} s to {time[run.stop - 1]:.4g} s while its command moves"
            yield Fault(
                "stuck", name, f"{what}: a stuck sensor, or a joint that is; empty the cells, or look at the joint"
            )
            return


def command_faults(
    robot: Robot, recording: Recording, index: int, name: str, summary: Mapping[str, Any]
) -> Iterator[Fault]:
    """A command at its limits, in degrees, or of a motor that is never on.

    Args:
        robot: with the recording's settings.
        recording: its commands.
        index: of the command.
        name: of the command, as of `Robot.command_columns`.
        summary: the entry of `commands` that `judge` returns.
    """
    if summary["saturated"] is not None and summary["saturated"] > SATURATED:
        what = f"at or beyond its limits in {summary['saturated']:.0%} of the rows"
        yield Fault("saturation", f"ctrl.{name}", f"{what}; there the motor cannot show what it does: command less")
    if summary["enabled"] == 0.0:
        yield Fault("motor_off", f"ctrl.{name}", "the motor is off all the time; is enable.* mapped the right way?")
    actuator = int(actuator_of_input(robot.model)[index])
    joint = robot.joint_of_actuator(actuator)
    hinge = joint is not None and robot.model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_HINGE
    largest = float(np.abs(recording.ctrl[:, index] * gear_of(robot.model, actuator)).max())
    if hinge and index == target_input(robot.model, actuator) and largest > FULL_TURNS:
        yield Fault(
            "degrees", f"ctrl.{name}", f'commands up to {largest:.4g} rad; is it in degrees? Then give unit = "deg"'
        )


def target_input(model: mujoco.MjModel, actuator: int) -> int | None:
    """Address in `ctrl` of an actuator's target position; None where it has none, or integrates it."""
    direct = model.actuator_dyntype[actuator] != mujoco.mjtDyn.mjDYN_INTEGRATOR
    return position_input(model, actuator) if direct else None
