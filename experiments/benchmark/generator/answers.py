"""The answer of a case: everything that a scorer needs and nobody else may see."""

from __future__ import annotations

from dataclasses import asdict
from math import sqrt
from typing import Any

import numpy as np

from experiments.benchmark.generator.case import Case, Planted
from experiments.benchmark.generator.catalogue import CATALOGUE
from experiments.benchmark.generator.effect import Effect
from experiments.benchmark.generator.robots import ROBOTS, layout
from experiments.benchmark.generator.sensing import channels

_INNER = ("source", "reference", "axis", "times", "ratio")
"""Parameters of ours that no name of the catalogue has."""
_SPUN = ("leg", "arm6", "cartpole", "scara")
"""Robots on whose first joint the first link's weight has no lever: all that its mass adds there is inertia."""
_JAMMED = 0.5
"""Degree from which on a jam is distinguished from viscous friction."""


def answer(case: Case) -> dict[str, Any]:
    """The answer, as JSON."""
    plan = case.plan
    effects = [_effect(p, e, plan.robot) for p, e in zip(plan.planted, case.effects, strict=True)]
    return {
        "group": plan.group,
        "robot": plan.robot,
        "plan": asdict(plan),
        "shorter": case.shorter,
        "engine": "by hand" if plan.by_hand else "mujoco",
        "effects": effects,
        "equivalents": equivalents(case),
        "axes": axes(plan.robot),
        "onset_s": {r.name: r.onset for r in case.recorded if r.name.startswith("train")},
        "length_s": {r.name: float(r.rows.time[-1]) for r in case.recorded},
        "visibility": _visibility(case),
        "parameters_wrong": case.wrong,
        "parameter_deviation": case.deviation,
        "instruments": asdict(case.instruments),
    }


def _visibility(case: Case) -> dict[str, Any]:
    """Errors in noise floors, and `shown`: what the effect leaves after the refit in training and test, the smaller.

    What the robot leaves without the effect, `twin`, is taken out.
    """
    v = case.visible
    twin = dict.fromkeys(v.refit, 0.0) if case.twin is None else case.twin.refit
    coarse = any(p.effect == "time_step" for p in case.plan.planted)
    left = [sqrt(max(v.refit[role] ** 2 - twin[role] ** 2, 0.0)) for role in ("train", "test")]
    shown = v.step if coarse else min(left)
    return {"floor": v.floor, "nominal": v.nominal, "refit": v.refit, "twin": twin, "step": v.step, "shown": shown}


def _effect(planted: Planted, effect: Effect, robot: str) -> dict[str, Any]:
    kind = CATALOGUE[planted.effect]
    return {
        "effect": kind.name,
        "law": kind.law,
        "kind": kind.kind,
        "name": element(planted, robot),
        "axis": None
        if planted.joint < 0 or kind.kind in ("environment", "numerics")
        else layout(robot).joints[planted.joint],
        "strength": planted.strength,
        "parameters": {k: v for k, v in effect.parameters.items() if k not in _INNER},
        "scored": list(kind.scored),
        "accepted": [*kind.accepted, *_merged(kind.name, effect)],
    }


def _merged(name: str, effect: Effect) -> list[str]:
    """Under which other name it goes: a jam that is not one yet is viscous friction."""
    return ["viscous_friction"] if name == "joint_jam" and effect.parameters["f"] < _JAMMED else []


def element(planted: Planted, robot: str) -> str | None:
    """The MJCF element an effect is at; `*` for all motors."""
    kind, place, j = CATALOGUE[planted.effect].kind, layout(robot), planted.joint
    if kind == "actuator":
        return "*" if j < 0 else place.actuators[place.drives.index(j)]
    if planted.effect == "external_force" or kind == "body":
        return place.body[j]
    if kind == "sensor":
        found = [c.name for c in channels(ROBOTS[robot].model, place) if c.joint == j and c.kind == "position"]
        return found[0]
    return place.joints[j] if kind == "joint" else None


def axes(robot: str) -> dict[str, str]:
    """`kind name` of every element, and the joint it belongs to: a motor, sensor or body is at its joint."""
    place, found = layout(robot), {}
    for j, name in enumerate(place.joints):
        found[f"joint {name}"] = found[f"body {place.body[j]}"] = name
    for a, name in enumerate(place.actuators):
        found[f"actuator {name}"] = place.joints[place.drives[a]]
    for c in channels(ROBOTS[robot].model, place):
        found[f"sensor {c.name}"] = place.joints[c.joint]
    return found


def equivalents(case: Case) -> list[list[str]]:
    """For each effect, names that say the same on these recordings, so count as right where equivalents count.

    Without a stretch with the motor off, back-EMF and viscous friction differ only in what a torque sensor shows. On a
    planar robot gravity's tilt, the first joint's zero offset and its sensor's bias differ only in servo commands; at
    any other joint the last two do. These robots have motors without servos. The mass of a first link whose weight has
    no lever on its joint is rotor inertia.
    """
    torque = any(c.kind == "torque" for c in channels(ROBOTS[case.plan.robot].model, layout(case.plan.robot)))
    off = any(not np.all(r.rows.enable) for r in case.recorded)
    drags = {"back_emf", "viscous_friction"} if not off and not torque else set()
    shifted = {"joint_offset", "sensor_bias"} if case.plan.robot in ("planar", "cartpole") else set()
    turned = {"gravity_tilt", *shifted} if shifted else set()
    found = []
    for p in case.plan.planted:
        name = CATALOGUE[p.effect].name
        first = p.joint in (-1, 0 if case.plan.robot == "planar" else 1)
        inert = {"body_mass", "armature"} if p.joint == 0 and case.plan.robot in _SPUN else set()
        groups = [g for g in (drags, turned if first else shifted, inert) if name in g]
        found.append(sorted(set().union(*groups) - {name}) if groups else [])
    return found
