"""Which unknown laws are looked for, and which of them to believe."""

from __future__ import annotations

from dataclasses import replace

from estexp_jax.discovery.fitting import FAR
from estexp_jax.discovery.hypotheses import Place
from estexp_jax.discovery.location import element
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.selection import Explanation, Selection, worth
from estexp_jax.discovery.verdict import QUIET, verdict
from estexp_jax.inference.accuracy import gain
from estexp_jax.physics.effects.laws.base import JointLaw
from estexp_jax.physics.registry import effect
from estexp_jax.physics.robot import Robot

_PLAINLY = 0.3
"""Names that leave something of the mismatch give way only to what brings the squared error under this share."""
_WHOLE = 0.85
"""Share of the excess error that a law, or names piled up at a joint, must remove where they leave more than `FAR`:
another law, bent to what was recorded, loses its way on other motions. In development true ones left up to 6
deviations, wrong ones 10 to 50."""
_HALF = 0.5
"""Share of the squared error to which each term of a law must bring it: what is flexible must pay more."""


def is_law(place: Place) -> bool:
    """Whether a claim is a term of an unknown law."""
    return isinstance(effect(place[0]), JointLaw)


def needed(robot: Robot, selection: Selection) -> bool:
    """Whether nothing named explains the mismatch, or what does leaves more than noise may."""
    judged = verdict(robot, selection, selection.chosen.claims)
    if selection.seen:
        return False
    return judged == "unexplained" or (judged == "missing_physics" and selection.chosen.error > QUIET)


def crowded(robot: Robot, selection: Selection) -> str | None:
    """The joint where an explanation claims several forces, if any: what no name says may be put together of them."""
    if verdict(robot, selection, selection.chosen.claims) != "missing_physics" or selection.seen:
        return None
    sites = [pushed(robot, place) for place in selection.chosen.places]
    joint = max((s for s in sites if s in robot.names("joint")), key=sites.count, default=None)
    return joint if joint is not None and sites.count(joint) > 1 else None


def pushed(robot: Robot, place: Place) -> str | None:
    """The joint whose force a claim changes, itself or by its motor; None for what acts elsewhere."""
    kind, name = element(robot, place)
    return name if kind == "joint" and effect(place[0]).side == "plant" else None


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

    Args:
        robot: the nominal robot.
        found: with laws.
        named: without.
        problem: the comparison about what is chosen with laws.
    """
    chosen, best = found.chosen, min((named.parameters, *named.tried), key=lambda e: e.error)
    if verdict(robot, named, named.chosen.claims) != "unexplained":
        better = chosen.held_out.sum() < _PLAINLY * best.held_out.sum()
    else:
        better = worth(chosen, best)
    if not better:
        return False
    if not whole(found) or verdict(robot, found, chosen.claims) != "missing_physics":
        return False
    plain = replace(problem, step=None, own={})
    windows = problem.fitted
    return plain.error(chosen.fitted.member, windows) < plain.error(found.nominal.fitted.member, windows)


def without_piles(robot: Robot, named: Selection, nearer: Selection | None = None) -> Selection:
    """The same, but several names at one joint that leave much of the mismatch are no explanation: they make up one.

    Args:
        robot: the nominal robot.
        named: what was chosen among names.
        nearer: the same by shorter windows, if they were asked: what is whole there is.
    """
    return named if crowded(robot, named) is None or whole(nearer or named) else replace(named, piled=True)


def whole(found: Selection) -> bool:
    """Whether what is chosen is the whole of what is wrong: near the noise, or nearly all of the mismatch."""
    as_it_is = min(found.nominal, found.corrected, key=lambda e: e.error)
    return found.chosen.error <= FAR or gain(found.chosen.error, as_it_is.error, 1.0) >= _WHOLE
