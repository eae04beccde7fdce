"""Which cases are planted: every effect at every robot that it fits, nothing, pairs, onsets, and a walking robot."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from experiments.benchmark.generator.case import Plan, Planted
from experiments.benchmark.generator.catalogue import SINGLE, places

ROBOTS = ("leg", "planar")
SEEDS, NOTHING, TWO, ONSET = 5, 100, 20, 20
"""Cases of each effect at each robot; with nothing missing; with two effects; with an onset half-way."""
_WEAKEST, _PLAINEST = 0.1, 0.7
_BEGINNING = ("coulomb_friction", "viscous_friction", "motor_weakness", "command_delay", "body_mass", "backlash")
_WALKING = {
    "body_mass": None,
    "ground_friction": None,
    "gravity_tilt": None,
    "motor_weakness": None,
    "coulomb_friction": None,
    "command_delay": -1,
}
"""Effects of the quadruped, and the joint where it is not drawn."""


def planned(seed: int, part: str = "all") -> list[Plan]:
    """The plans of a set, in an order that tells nothing; a part of them if it is named.

    Args:
        seed: decides everything.
        part: all, single, nothing, two, onset or walking.
    """
    found: list[Plan] = []
    for k, (name, draw) in enumerate(_PARTS.items()):
        rng = np.random.default_rng([seed, 7, k])
        own = [replace(p, seed=int(rng.integers(2**62)), plain=True) for p in draw(rng)]
        found += own if part in ("all", name) else []
    order = np.random.default_rng([seed, 8]).permutation(len(found))
    return [found[i] for i in order]


def _single(rng: np.random.Generator) -> Iterator[Plan]:
    for robot in ROBOTS:
        for name in SINGLE:
            for _ in range(SEEDS if places(name, robot) else 0):
                yield Plan("single", robot, (_planted(name, robot, rng),), 0)


def _nothing(rng: np.random.Generator) -> Iterator[Plan]:
    for i in range(NOTHING):
        yield Plan(("null", "parameters")[i % 2], ROBOTS[i // 2 % 2], (), 0)


def _two(rng: np.random.Generator) -> Iterator[Plan]:
    found = 0
    while found < TWO:
        robot, names = ROBOTS[found % 2], rng.choice(SINGLE, 2, replace=False).tolist()
        if all(places(n, robot) for n in names) and "time_step" not in names:
            yield Plan("pair", robot, tuple(_planted(n, robot, rng) for n in names), 0)
            found += 1


def _onset(rng: np.random.Generator) -> Iterator[Plan]:
    for i in range(ONSET):
        robot = ROBOTS[i % 2]
        yield Plan("onset", robot, (_planted(_BEGINNING[i // 2 % len(_BEGINNING)], robot, rng),), 0)


def _walking(rng: np.random.Generator) -> Iterator[Plan]:
    for name, joint in _WALKING.items():
        for _ in range(SEEDS):
            planted = _planted(name, "quadruped", rng)
            yield Plan("single", "quadruped", (planted if joint is None else replace(planted, joint=joint),), 0)


def _planted(name: str, robot: str, rng: np.random.Generator) -> Planted:
    strength = float(np.exp(rng.uniform(np.log(_WEAKEST), np.log(_PLAINEST))))
    return Planted(name, int(rng.choice(places(name, robot))), strength)


_PARTS = {"single": _single, "nothing": _nothing, "two": _two, "onset": _onset, "walking": _walking}
PARTS = ("all", *_PARTS)
