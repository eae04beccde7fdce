"""Which unknown laws are looked for, and which of them to believe."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import mujoco

from estexp_jax.discovery.fitting import FAR
from estexp_jax.discovery.hypotheses import Place
from estexp_jax.discovery.location import element
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.selection import NOISE, Explanation, Selection, simplest, tied, worth
from estexp_jax.discovery.verdict import verdict
from estexp_jax.estimation.accuracy import gain
from estexp_jax.physics.effects.laws.base import JointLaw
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.model.robot import Robot

_LEFT = 1.5
"""Deviations that names may leave; more, and laws are asked."""
_PLAINLY = 0.3
"""Names that leave something of the mismatch give way only to what brings the squared error under this share, or to
near the noise."""
_WHOLE = 0.85
"""Share of the excess error that a law, or names piled up at a joint, must remove where they leave more than `FAR`:
another law, bent to what was recorded, loses its way on other motions. In development true ones left up to 6
deviations, wrong ones 10 to 50."""
_HALF = 0.5
"""Share of the squared error to which each term of a law must bring it: what is flexible must pay more."""

_MANY = 3
"""Numbers of a claim that are many for one: a term of a law with fewer may say the same."""
_HEAP = 5
"""Numbers more than a term's that names have only where they make up for it: more than a spring and cogging."""


def is_law(place: Place) -> bool:
    """Whether a claim is a term of an unknown law."""
    return isinstance(effect(place[0]), JointLaw)


def needed(robot: Robot, selection: Selection) -> bool:
    """Whether nothing named explains the mismatch, or what does leaves more than noise may."""
    judged = verdict(robot, selection, selection.chosen.claims)
    if selection.seen:
        return False
    return judged == "unexplained" or (judged == "missing_physics" and selection.chosen.error > _LEFT)


def crowded(robot: Robot, selection: Selection) -> str | None:
    """The joint where an explanation claims several forces, if any: what no name says may be put together of them."""
    return _shared(robot, selection, [pushed(robot, place) for place in selection.chosen.places])


def doubled(robot: Robot, selection: Selection) -> str | None:
    """The joint where it claims a force, or something of the body there, beside another one or a fault of its sensor.

    Or faults of several of its sensors. One law may look like all that: where a spring that stiffens holds a joint
    back, its sensor seems to show too little; where a motor is late, all that shows its joint seems to be.
    """
    places = selection.chosen.places
    acting = {_acts(robot, place) for place in places}
    sensors = {(about_joint(robot, (name, site)), site) for name, site in places if effect(name).kind == "sensor"}
    sensed = [joint for joint, _ in sensors]
    sites = [about_joint(robot, place) for place in places]
    return _shared(robot, selection, [site for site in sites if site in acting or sensed.count(site) > 1])


def manifold(robot: Robot, selection: Selection) -> str | None:
    """The joint where it claims something of many numbers, if any: what has many bends to much."""
    many = [p for p in selection.chosen.places if len(effect(p[0]).parameters) >= _MANY]
    return _shared(robot, selection, [_acts(robot, place) for place in many], 1)


def nearly(robot: Robot, selection: Selection) -> str | None:
    """The joint that its only claim is about, if that leaves a little more than noise and too little to ask laws for.

    So does what is almost the right thing: a torque that is told late looks much like one that is braked.
    """
    chosen = selection.chosen
    if len(chosen.places) != 1 or not NOISE < chosen.error <= _LEFT:
        return None
    return _shared(robot, selection, [about_joint(robot, chosen.places[0])], 1)


def _shared(robot: Robot, selection: Selection, sites: Sequence[str | None], least: int = 2) -> str | None:
    """The joint that most claims of an explanation are at, if they are several."""
    if selection.seen or verdict(robot, selection, selection.chosen.claims) != "missing_physics":
        return None
    joint = max((s for s in sites if s in robot.names("joint")), key=sites.count, default=None)
    return joint if joint is not None and sites.count(joint) >= least else None


def about_joint(robot: Robot, place: Place) -> str | None:
    """The joint whose force a claim changes, or whose sensor, body or zero it is about; None if there is none."""
    kind, name = element(robot, place)
    if effect(place[0]).moves_zero:
        return name
    if kind != "sensor" or name not in robot.names("sensor"):
        return _acts(robot, place)
    sensor = robot.index("sensor", name)
    of_joint = int(robot.model.sensor_objtype[sensor]) == int(mujoco.mjtObj.mjOBJ_JOINT)
    return robot.names("joint")[int(robot.model.sensor_objid[sensor])] if of_joint else None


def pushed(robot: Robot, place: Place) -> str | None:
    """The joint whose force a claim changes, itself or by its motor; None for what acts elsewhere."""
    kind, name = element(robot, place)
    e = effect(place[0])
    return name if kind == "joint" and e.side == "plant" and not e.moves_zero else None


def _acts(robot: Robot, place: Place) -> str | None:
    """The joint whose force a claim changes, or that alone moves the body that it is about; None if there is none."""
    kind, name = element(robot, place)
    if kind not in ("body", "environment") or name not in robot.names("body"):  # a force from outside pulls at a body
        return pushed(robot, place)
    model, body = robot.model, robot.index("body", name)
    return robot.names("joint")[int(model.body_jntadr[body])] if model.body_jntnum[body] == 1 else None


def fewest_terms(found: Selection) -> Explanation:
    """The explanation with the fewest of the chosen one's terms, each of which halves what is left at least."""
    chosen = found.chosen
    if not any(is_law(p) for p in chosen.places):
        return chosen
    parts = [e for e in found.tried if e.places and set(e.places) < set(chosen.places)]
    spared = [len(chosen.places) - len(e.places) for e in parts]
    enough = [e for e, n in zip(parts, spared, strict=True) if e.held_out.sum() * _HALF**n <= chosen.held_out.sum()]
    return min(enough, key=lambda e: (len(e.places), e.error), default=chosen)


def believed(robot: Robot, found: Selection, named: Selection, problem: Problem) -> bool:
    """Whether a law explains held-out windows as well as claims must, and clearly better than anything named.

    Of names with more numbers than the law has, it is the simpler one: it need only predict as well.

    Args:
        robot: the nominal robot.
        found: with laws.
        named: without.
        problem: the comparison about what is chosen with laws.
    """
    chosen, others = found.chosen, sorted((named.parameters, *named.tried), key=lambda e: e.error)
    best, numbers = others[0], len(chosen.fitted.hypothesis.free)
    quiet = chosen.error <= NOISE and best.error > _LEFT
    plainly = quiet or chosen.held_out.sum() < _PLAINLY * best.held_out.sum()
    if not (plainly or verdict(robot, named, named.chosen.claims) == "unexplained"):
        return False
    simpler = next((e for e in others if len(e.fitted.hypothesis.free) <= numbers), best)
    if not worth(chosen, simpler) or chosen.error > best.error:
        return False
    if not whole(found) or verdict(robot, found, chosen.claims) != "missing_physics":
        return False
    plain = replace(problem, step=None, own={})
    windows = problem.fitted
    return plain.error(chosen.fitted.member, windows) < plain.error(found.nominal.fitted.member, windows)


def outdoes(term: Explanation, names: Explanation, n: int) -> bool:
    """Whether a term in the place of n names about a joint is to be believed rather than they.

    Several say no more than a term of fewer numbers that predicts as well, or leaves nothing to explain; where it
    spares many numbers, nothing but noise. A name that stands alone says more: it gives way only to what predicts
    better and leaves nothing but noise.
    """
    spared = len(names.fitted.hypothesis.free) - len(term.fitted.hypothesis.free)
    if n > 1 and spared > 0 and term.error <= (NOISE if spared >= _HEAP else 1.0):
        return True
    return simplest([names, term]) is term and (n > 1 or (term.error <= NOISE and not tied(names, term)))


def without_piles(robot: Robot, named: Selection, nearer: Selection | None = None) -> Selection:
    """The same, but several names at one joint that leave much of the mismatch are no explanation: they make up one.

    Of a robot's only joint that says nothing: whatever acts on it acts there.

    Args:
        robot: the nominal robot.
        named: what was chosen among names.
        nearer: what shorter windows chose, if they were asked: where it is the same, what is whole there is.
    """
    if nearer is None or set(nearer.chosen.places) != set(named.chosen.places):
        nearer = named
    if robot.model.njnt == 1 or crowded(robot, named) is None or whole(nearer):
        return named
    return replace(named, piled=True)


def whole(found: Selection) -> bool:
    """Whether what is chosen is the whole of what is wrong: near the noise, or nearly all of the mismatch.

    So is what leaves nothing but noise where it is fitted to all windows, even if some of them do not tell the others.
    """
    as_it_is, chosen = min(found.nominal, found.corrected, key=lambda e: e.error), found.chosen
    near = chosen.error <= FAR or chosen.fitted.cost <= 1.0
    return near or gain(chosen.error, as_it_is.error, 1.0) >= _WHOLE
