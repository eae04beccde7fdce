"""Where effects act, which commands and readings they change: the tables of an `explained.py`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from estexp_jax.physics.effects.base import (
    BodyForce,
    CommandLaw,
    CommandShift,
    Distortion,
    Effect,
    ReadingDrift,
    ReadingShift,
)
from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.effects.controller_fault import CommandRoute
from estexp_jax.physics.effects.elements import element_values
from estexp_jax.physics.effects.logging_fault import LoggingFault
from estexp_jax.physics.effects.registry import effect, every
from estexp_jax.physics.engines.c.instances import at_work
from estexp_jax.physics.engines.c.numpy_operations import UnknownOperation
from estexp_jax.physics.engines.motor_readings import motor_readings
from estexp_jax.physics.engines.motors import drives
from estexp_jax.physics.engines.standalone.assignments import change_values
from estexp_jax.physics.engines.standalone.runtime import DelayedCommand, DisplayedVariable, LawPlace, Reading
from estexp_jax.physics.model.robot import Robot

Marked = Sequence[tuple[Change, bool]]
"""Changes, each with whether model_explained.xml holds it."""


def changes_in_order(changes: Marked) -> list[tuple[Change, bool]]:
    """Changes in the order in which they act: what changes commands first; faults of logging do not act."""
    order = {e.name: (not isinstance(e, CommandLaw), i) for i, e in enumerate(every())}
    kept = [(c, native) for c, native in changes if not isinstance(effect(c.effect), LoggingFault)]
    return sorted(kept, key=lambda one: order[one[0].effect])


def by_effect(changes: Marked) -> list[tuple[Effect, list[tuple[Change, bool]]]]:
    """Changes of each effect, in their order."""
    names = dict.fromkeys(c.effect for c, _ in changes)
    return [(effect(name), [one for one in changes if one[0].effect == name]) for name in names]


def places_of(robot: Robot, e: Any, own: Marked) -> tuple[list[LawPlace], list[int]]:
    """Where an effect acts, and the index of the element at each place."""
    found, elements = list[LawPlace](), list[int]()
    for native in (True, False):
        some = [c for c, marked in own if marked == native]
        if not some:
            continue
        values = _values(robot, e, some)
        at = values if isinstance(e, BodyForce) else element_values(e, robot, values)
        for i in np.flatnonzero(at_work(e, at[None])[0]).tolist():
            found.append(_place(robot, e, i, at[i], native))
            elements.append(i)
    return found, elements


def _values(robot: Robot, e: Any, changes: Sequence[Change]) -> np.ndarray:
    """Values (n_sites, n_parameters) of changes of one effect, each at a site of its own."""
    neutral = np.array([p.neutral for p in e.parameters])
    found = np.tile(neutral, (len(e.sites(robot)), 1))
    for change in changes:
        own = change_values(e, robot, change)
        found = np.where(own != neutral, own, found)
    return found


def _place(robot: Robot, e: Any, i: int, p: np.ndarray, native: bool) -> LawPlace:
    values = tuple(float(x) for x in p)
    if isinstance(e, BodyForce):
        return LawPlace(values, body=e.sites(robot)[i], native=native)
    if isinstance(e, CommandLaw):
        motor = int(e.actuators(robot)[i])
        joint = robot.joint_of_actuator(motor)
        name = robot.names("joint")[joint] if joint in robot.scalar_joints and joint is not None else ""
        return LawPlace(values, name, (robot.names("actuator")[motor],), native=native)
    there = drives(robot, e.dofs(robot)[i : i + 1], None if e.motors(robot) is None else e.motors(robot)[i : i + 1])
    motors = [robot.names("actuator")[a] for a, is_one in zip(there.motors[0], there.there[0], strict=True) if is_one]
    joint = robot.names("joint")[int(there.joint[0])]
    body = robot.names("body")[int(e.bodies(robot)[i])] if e.kind == "body" else ""
    return LawPlace(values, joint, tuple(motors), there.whole, float(there.limit()[0]), body, native)


def delayed_commands(robot: Robot, changes: Marked) -> list[DelayedCommand]:
    """The commands that come late, or from elsewhere."""
    model, found = robot.model, list[DelayedCommand]()
    columns = [
        (robot.names("actuator")[a], part)
        for a in range(model.nactuator)
        for part in range(int(model.actuator_ctrlnum[a]))
    ]
    for native in (True, False):
        own = [c for c, marked in changes if marked == native]
        delay, source = np.zeros(model.nu), np.arange(model.nu)
        for e, some in by_effect([(c, native) for c in own]):
            if not isinstance(e, CommandShift | CommandRoute):
                continue
            values = _values(robot, e, [c for c, _ in some])
            if isinstance(e, CommandShift):
                delay = delay + e.shift(robot, values)
            else:
                other = np.asarray(e.route(robot, values))
                source = np.where(other >= 0, other, source)
        for k in np.flatnonzero((delay != 0.0) | (source != np.arange(model.nu))).tolist():
            from_ = columns[int(source[k])] if source[k] != k else ("", 0)
            found.append(DelayedCommand(*columns[k], float(delay[k]), *from_, native))
    return found


def faulty_readings(robot: Robot, changes: Marked) -> list[Reading]:
    """What is faulty of readings: faults that are affine in the reading, delays and drifts."""
    model, found = robot.model, list[Reading]()
    columns = [(name, part) for s, name in enumerate(robot.names("sensor")) for part in range(int(model.sensor_dim[s]))]
    for native in (True, False):
        n = model.nsensordata
        zero, one, delay, drift = np.zeros(n), np.ones(n), np.zeros(n), np.zeros(n)
        for e, some in by_effect([one for one in changes if one[1] == native]):
            if not isinstance(e, Distortion | ReadingShift | ReadingDrift):
                continue
            values = _values(robot, e, [c for c, _ in some])
            if isinstance(e, Distortion):
                zero, one = (_distorted(robot, e, x, values) for x in (zero, one))
                mixed = np.arange(1.0, n + 1.0)
                if not np.allclose(_distorted(robot, e, mixed, values), _line(robot, e, values, mixed)):
                    raise UnknownOperation(e.name)
            elif isinstance(e, ReadingShift):
                delay = delay + e.shift(robot, values)
            else:
                drift = drift + e.rate(robot, values)
        for k in range(n):
            reading = Reading(
                *columns[k], float(one[k] - zero[k]), float(zero[k]), float(delay[k]), float(drift[k]), native
            )
            if reading[2:6] != (1.0, 0.0, 0.0, 0.0):
                found.append(reading)
    return found


def _distorted(robot: Robot, e: Distortion, readings: np.ndarray, values: np.ndarray) -> np.ndarray:
    with jax.enable_x64(True):
        return np.asarray(e.distort(robot, jnp.asarray(readings), jnp.asarray(values)), float)


def _line(robot: Robot, e: Distortion, values: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Faulty readings, if each depends on itself alone, and in proportion."""
    zero, one = (_distorted(robot, e, base, values) for base in (np.zeros_like(x), np.ones_like(x)))
    return zero + (one - zero) * x


def displayed_variables(
    robot: Robot, effects: Sequence[Effect], where_of: Mapping[tuple[str, int], tuple[int, int]]
) -> list[DisplayedVariable]:
    """Hidden variables that sensors show.

    Args:
        robot: the nominal robot.
        effects: at work.
        where_of: numbers of the law and of its place, of each effect's name and element.
    """
    model = robot.model
    found = list[DisplayedVariable]()
    for s in motor_readings(robot, tuple(dict.fromkeys(effects))):
        if (s.effect, s.row) in where_of:
            sensor = int(np.searchsorted(model.sensor_adr, s.column, side="right")) - 1
            part = s.column - int(model.sensor_adr[sensor])
            found.append(
                DisplayedVariable(robot.names("sensor")[sensor], part, *where_of[s.effect, s.row], s.state, s.factor)
            )
    return found
