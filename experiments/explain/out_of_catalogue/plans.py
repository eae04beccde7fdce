"""Which effects are left out of the catalogue where they act, and which laws were never in it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from estexp_jax.physics.effects.registry import every
from experiments.benchmark.generator.case import Plan, Planted
from experiments.benchmark.generator.catalogue import CATALOGUE, OTHERS, SINGLE, places

ROBOTS, SEEDS = ("leg", "planar"), 5
LEFT = tuple(name for name in SINGLE if CATALOGUE[name].kind in ("joint", "actuator"))
"""Effects that are left out one by one."""
_DAMPING = {"viscous_friction", "joint_jam", "back_emf"}
"""One law, tau = -c w: in little, in much, and while a motor is on."""
_TURNED = {"com_shift", "gravity_tilt"}
"""What a joint's zero is as well: a last link that is turned has its mass elsewhere, and a robot that is turned at its
first joint feels gravity from elsewhere."""
_WEAKEST, _PLAINEST = 0.15, 0.7
_TESTS = (0.6, 0.9)
"""Amplitudes of the test recordings: the training recordings' own, and beyond."""


def planned(seed: int, part: str = "all") -> list[Plan]:
    """The plans of a set, in an order that tells nothing; a part of them if it is named.

    Args:
        seed: decides everything.
        part: all, left_out or own.
    """
    found: list[Plan] = []
    for k, (name, laws) in enumerate(_LAWS.items()):
        own = list(_drawn(name, laws, np.random.default_rng([seed, 17, k])))
        found += own if part in ("all", name) else []
    order = np.random.default_rng([seed, 18]).permutation(len(found))
    return [found[i] for i in order]


def left_out(plan: Plan) -> tuple[str, ...]:
    """What the catalogue lacks for a case: the effect with its whole ladder, whatever contains or nearly equals it.

    With Stribeck friction go Coulomb friction, which it contains, and hysteresis, whose bristles do the same; with one
    of the dampings go the others; with a joint's zero go moved centres of mass and a tilt.
    """
    [planted] = plan.planted
    if planted.effect in OTHERS:
        return ()
    rungs = [(e.name, e.nested_in) for e in every() if e.nested_in]
    ladder, before = {planted.effect}, set[str]()
    while ladder != before:
        before = set(ladder)
        ladder |= {end for rung in rungs if ladder.intersection(rung) for end in rung}
    ladder |= _DAMPING if planted.effect in _DAMPING else set()
    return tuple(sorted(ladder | _TURNED if planted.effect == "joint_offset" else ladder))


def _drawn(part: str, laws: tuple[str, ...], rng: np.random.Generator) -> Iterator[Plan]:
    for robot in ROBOTS:
        for law in laws:
            for _ in range(SEEDS if places(law, robot) else 0):
                strength = float(np.exp(rng.uniform(np.log(_WEAKEST), np.log(_PLAINEST))))
                planted = Planted(law, int(rng.choice(places(law, robot))), strength)
                seed = int(rng.integers(2**62))
                yield Plan(part, robot, (planted,), seed, plain=True, tests=_TESTS)


_LAWS = {"left_out": LEFT, "own": OTHERS}
PARTS = ("all", *_LAWS)
