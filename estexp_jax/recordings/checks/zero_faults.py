"""Positions whose zero is elsewhere: beyond the limits of their joint, or beside their servo's command all the time."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from estexp_jax.physics.model.actuators import gear_of
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.model.scales import gravity_torque
from estexp_jax.recordings.checks.faults import Fault

_OUTSIDE = 0.02
"""Share of rows beyond a joint's limits above which they are told: a robot at its stop gives a little, for a little."""
_MARGIN, _SHARE = 0.05, 0.03
"""What counts as beyond: so much, rad (a fifth of it in m), and so much of the range."""
_OFFSET = 0.1
"""Smallest offset that is told, rad; a fifth of it in m."""
_STEADY = 0.35
"""Largest spread of the offset, as a share of it: else it is no offset."""
_SAGS = 1.5
"""An offset of so many times what gravity does to the servo may be gravity."""
_TURN = 2.0 * np.pi
_ROUND = 0.3
"""Of a whole turn an offset is one that differs from it by less, rad."""


def limit_faults(robot: Robot, joint: int, name: str, values: np.ndarray) -> Iterator[Fault]:
    """A position that its joint cannot have.

    Args:
        robot: the nominal one.
        joint: of one coordinate.
        name: our column.
        values: (n,) samples, rad or m.
    """
    model = robot.model
    if not model.jnt_limited[joint] or not len(values):
        return
    low, high = model.jnt_range[joint].tolist()
    margin = _MARGIN * _unit(model, joint) + _SHARE * (high - low)
    share = float(np.mean((values < low - margin) | (values > high + margin)))
    if share <= _OUTSIDE:
        return
    farthest = float(values[np.argmax(np.maximum(low - values, values - high))])
    what = f"lies beyond its joint's limits of {low:.4g} to {high:.4g} in {share:.0%} of the rows, up to {farthest:.4g}"
    turns = round((float(np.median(values)) - 0.5 * (low + high)) / _TURN) if _is_hinge(model, joint) else 0
    back = values - turns * _TURN
    if turns and np.mean((back < low - margin) | (back > high + margin)) <= _OUTSIDE:
        remedy = f"it is {_in_turns(turns)} off: give offset = {-turns * _TURN:.6g}"
    else:
        remedy = "give its scale, sign or offset, or mend the range of the joint in the model"
    yield Fault("beyond_limits", name, f"{what}; {remedy}")


def offset_faults(
    robot: Robot, actuator: int, joint: int, name: str, motion: tuple[np.ndarray, np.ndarray, np.ndarray]
) -> Iterator[Fault]:
    """A reading that lies beside its position servo's command all the time, by more than gravity can explain.

    What is proportional to the command's speed is the servo's lag, and no offset.

    Args:
        robot: the nominal one; of one that is not bolted down nothing is said, since its own weight moves its servos.
        actuator: the servo.
        joint: that it drives.
        name: our column of the reading.
        motion: time, s, target positions and measured ones, rad or m, each (n,).
    """
    model = robot.model
    stiffness = -float(model.actuator_biasprm[actuator, 1]) * gear_of(model, actuator) ** 2
    if stiffness <= 0.0 or np.any(model.jnt_type == int(mujoco.mjtJoint.mjJNT_FREE)):
        return
    time, command, reading = motion
    lagging = np.stack([np.ones(len(time)), np.gradient(command, time)], axis=1)
    parts = np.linalg.lstsq(lagging, reading - command, rcond=None)[0]
    offset, spread = float(parts[0]), float(np.std(reading - command - lagging @ parts))
    smallest = _OFFSET * _unit(model, joint) + _SAGS * gravity_torque(robot, joint) / stiffness
    if abs(offset) <= smallest or spread > _STEADY * abs(offset):
        return
    turns = round(offset / _TURN) if _is_hinge(model, joint) else 0
    is_turn = turns and abs(offset - turns * _TURN) < max(_ROUND, smallest)
    remedy = f"{_in_turns(turns)}: give offset = {-turns * _TURN:.6g}" if is_turn else f"give offset = {-offset:.3g}"
    what = f"is {offset:+.3g} {'rad' if _is_hinge(model, joint) else 'm'} beside its command all the time"
    yield Fault("offset", name, f"{what}, more than gravity makes of it: its zero is elsewhere; {remedy}")


def _in_turns(turns: int) -> str:
    return "one whole turn" if abs(turns) == 1 else f"{abs(turns)} whole turns"


def _is_hinge(model: mujoco.MjModel, joint: int) -> bool:
    return int(model.jnt_type[joint]) == int(mujoco.mjtJoint.mjJNT_HINGE)


def _unit(model: mujoco.MjModel, joint: int) -> float:
    """Of numbers that are given in rad, for a slide in m."""
    return 1.0 if _is_hinge(model, joint) else 0.2
