"""Edits of a model as assignments to single where_of of it, each of a named element."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from estexp_jax.physics.effects.base import Edit
from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.engines.c.edits import fields_after_edit
from estexp_jax.physics.engines.c.lane_models import c_field_of
from estexp_jax.physics.engines.standalone.runtime import Assignment
from estexp_jax.physics.model.robot import Robot

_LARGER = 1.25
"""By what a model's where_of are multiplied to see whether an edit adds to them, scales or replaces them."""
_ALIKE = 1e-9
_OWNERS = {"dof": "joint", "qpos": "joint", "jnt": "joint", "actuator": "actuator", "body": "body", "geom": "geom"}
_OWNERS |= {"sensor": "sensor", "tendon": "tendon"}


def assignments(robot: Robot, changes: Sequence[tuple[Change, bool]]) -> tuple[Assignment, ...]:
    """What edits among changes do to a robot's model, in the catalogue's order.

    Args:
        robot: the nominal robot.
        changes: each with whether the file of the corrected model holds it.
    """
    fields: dict[str, np.ndarray] = {}
    found = list[Assignment]()
    for change, native in changes:
        e = effect(change.effect)
        if not isinstance(e, Edit):
            continue
        before = lambda name: fields[name] if name in fields else np.asarray(c_field_of(robot.model, name))  # noqa: E731
        values = change_values(e, robot, change)
        after = fields_after_edit(robot, e, values, before)
        probe = fields_after_edit(robot, e, values, lambda name: _probed(before(name)))  # noqa: B023
        for name, new in after.items():
            old = before(name)
            for index in np.argwhere(~np.isclose(new, old, rtol=1e-12, atol=0.0)).tolist():
                at = tuple(index)
                op, value = _operation(*(float(x[at]) for x in (old, new, _probed(old), probe[name])))
                found.append(_edit(robot, name, at, op, value, native))
            fields[name] = new
    return tuple(found)


def change_values(e: Edit, robot: Robot, change: Change) -> np.ndarray:
    """Values (n_sites, n_parameters) of one change, in double precision."""
    sites = e.sites(robot)
    values = np.array([[p.neutral for p in e.parameters]] * len(sites), float)
    values[sites.index(change.name or "")] = [change.values[p.name] for p in e.parameters]
    return values


def _probed(x: np.ndarray) -> np.ndarray:
    """Other where_of, of which none is 0."""
    return np.where(x == 0, _LARGER, _LARGER * x) if x.dtype.kind == "f" else x


def _operation(old: float, new: float, probed_old: float, probed_new: float) -> tuple[str, float]:
    def alike(a: float, b: float) -> bool:
        return abs(a - b) <= _ALIKE * max(abs(a), abs(b), _ALIKE)

    if old == probed_old or alike(new, probed_new):
        return "set", new
    if alike(new - old, probed_new - probed_old):
        return "add", new - old
    return ("scale", new / old) if old and alike(new / old, probed_new / probed_old) else ("set", new)


def _edit(robot: Robot, field: str, at: tuple[int, ...], op: str, value: float, native: bool) -> Assignment:
    """An assignment by the name of its element."""
    model, prefix = robot.model, field.partition("_")[0].rstrip("0")
    if field.startswith("opt.") or prefix not in _OWNERS:
        return Assignment(field, "", "", at, op, value, native)
    i, rest = at[0], at[1:]
    if prefix == "dof":
        joint = int(model.dof_jntid[i])
        i, rest = joint, (i - int(model.jnt_dofadr[joint]), *rest)
    elif prefix == "qpos":
        joint = int(np.searchsorted(model.jnt_qposadr, i, side="right")) - 1
        i, rest = joint, (i - int(model.jnt_qposadr[joint]), *rest)
    elif field in ("actuator_ctrllimited", "actuator_ctrlrange"):
        i = int(np.searchsorted(model.actuator_ctrladr, i, side="right")) - 1
    elif field == "actuator_gear":
        i = int(np.searchsorted(model.actuator_outadr, i, side="right")) - 1
    kind = _OWNERS[prefix]
    return Assignment(field, kind, robot.names(kind)[i], rest, op, value, native)
