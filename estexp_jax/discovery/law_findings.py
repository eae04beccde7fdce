"""Unknown laws told: the terms at a joint as one equation with numbers, where it may be trusted, what it is like."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import mujoco
import numpy as np

from estexp_jax.discovery.force_residual import ForceResidual
from estexp_jax.discovery.slopes import Fit
from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.effects.laws.base import UNKNOWN_LAW, JointLaw
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.effects.written import mjcf_refusal
from estexp_jax.physics.model.robot import Robot

COVERED = (0.005, 0.995)
"""Quantiles of positions and speeds between which data cover a law."""


def law_entries(
    robot: Robot,
    seen: Sequence[ForceResidual],
    fitted: tuple[Fit, np.ndarray],
    terms: Sequence[tuple[Change, float]],
) -> list[dict[str, Any]]:
    """An entry of `what` for the terms at each joint.

    Args:
        robot: the nominal robot.
        seen: what its joints did in the training recordings.
        fitted: the explanation, and the intervals (n_free, 2) of its values.
        terms: the terms with the probability of each.
    """
    joints = dict.fromkeys(str(change.name) for change, _ in terms)
    return [_entry(robot, seen, fitted, joint, [t for t in terms if t[0].name == joint]) for joint in joints]


def equation(robot: Robot, terms: Sequence[Change]) -> str:
    """`tau = - 0.12 |w| w + 0.3 sin(7 q + 1.2)` of the terms at a joint, and what its letters mean."""
    text = " ".join(_law(c).formula(c.values) for c in terms).removeprefix("+ ")
    for number, name in enumerate(robot.names("joint"), start=1):
        text = text.replace(f"[joint {number}]", f"[{name}]")
    letters = dict.fromkeys(_law(c).symbols for c in terms if _law(c).symbols)
    return ", ".join([f"tau = {text}", *letters])


def covered(robot: Robot, seen: Sequence[ForceResidual], joint: str) -> str:
    """`|w| < 4.1 rad/s and -0.8 < q < 1.2 rad`: where recordings show what a joint does."""
    model, index, unit = robot.model, robot.index("joint", joint), joint_unit(robot, joint)
    q = np.concatenate([r.qpos[:, model.jnt_qposadr[index]] for r in seen])
    w = np.concatenate([np.abs(r.qvel[:, model.jnt_dofadr[index]]) for r in seen])
    (low, high), fast = np.quantile(q, COVERED), np.quantile(w, COVERED[1])
    return f"|w| < {fast:.3g} {unit}/s and {low:.3g} < q < {high:.3g} {unit}"


def joint_unit(robot: Robot, joint: str) -> str:
    """Unit of a joint's position: rad or m."""
    slides = int(robot.model.jnt_type[robot.index("joint", joint)]) == int(mujoco.mjtJoint.mjJNT_SLIDE)
    return "m" if slides else "rad"


def law_advice(what: Sequence[Mapping[str, Any]]) -> list[str]:
    """How far an unknown law is to be trusted.

    Args:
        what: entries of the findings.
    """
    return [
        f"The law found at {entry['name']} describes what the recordings show and names no cause: record motions beyond"
        " its range before relying on it there."
        for entry in what
        if entry["effect"] == UNKNOWN_LAW
    ]


def _entry(
    robot: Robot,
    seen: Sequence[ForceResidual],
    fitted: tuple[Fit, np.ndarray],
    joint: str,
    terms: Sequence[tuple[Change, float]],
) -> dict[str, Any]:
    changes = [change for change, _ in terms]
    text = equation(robot, changes)
    likeness = " and ".join(_law(c).resembles for c in changes)
    return {
        "effect": UNKNOWN_LAW,
        "kind": "joint",
        "name": joint,
        "probability": max(probability for _, probability in terms),
        "in_mjcf": not any(mjcf_refusal(robot, c) for c in changes),
        "sentence": (
            f"a law that no effect of the catalogue describes acts on the joint {joint}; it resembles {likeness}, "
            f"and may be trusted within {covered(robot, seen, joint)}, which the data cover"
        ),
        "equation": text,
        "parameters": _parameters(fitted, changes),
    }


def _parameters(fitted: tuple[Fit, np.ndarray], terms: Sequence[Change]) -> dict[str, dict[str, Any]]:
    """Each term's values with their intervals; of several terms, `c_drag` is the c of the term `law_drag`."""
    final, intervals = fitted
    rows = {(f.effect, f.site, f.parameter): i for i, f in enumerate(final.hypothesis.free)}
    found: dict[str, dict[str, Any]] = {}
    for change in terms:
        for p in effect(change.effect).parameters:
            low, high = intervals[rows[change.effect, change.name or "", p.name]]
            name = p.name if len(terms) == 1 else f"{p.name}_{change.effect.removeprefix('law_')}"
            value = float(change.values[p.name])
            found[name] = {"value": value, "low": float(low), "high": float(high), "unit": p.unit}
    return found


def _law(change: Change) -> JointLaw:
    law = effect(change.effect)
    assert isinstance(law, JointLaw)  # as `is_law` chose them
    return law
