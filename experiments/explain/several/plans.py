"""Which cases there are: arms of two, three and six joints, driven by torques or by servos, each with one flaw."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

ARMS = (2, 3, 6)
"""Driven joints of the arms."""
FLAWS = ("friction_along_path", "soft_mount", "varying_inertia")
"""What no name fits: friction that depends on where its joint is, a base that gives, a linkage of varying inertia."""
SEVERAL, NOTHING, FIRST = 60, 100, 6
"""Cases with several effects; with none; and how many of each the part `first` has."""
PARTS = ("all", "several", "nothing", "first")


@final
@dataclass(frozen=True)
class ArmPlan:
    """A case; its seed decides all the rest.

    Attributes:
        group: several or nothing.
        joints: of the arm.
        servo: driven by position servos, else by torques that a controller asks for.
        flaw: one of `FLAWS`.
        seed: of everything that is drawn.
        duration: of each recording, s.
    """

    group: str
    joints: int
    servo: bool
    flaw: str
    seed: int
    duration: float = 6.0


def planned(seed: int, part: str = "all") -> dict[str, ArmPlan]:
    """The plans of a part of a set by the ids of their cases: `first` has the first six of both groups."""
    found: dict[str, ArmPlan] = {}
    for k, (group, count) in enumerate((("several", SEVERAL), ("nothing", NOTHING))):
        seeds = np.random.default_rng([seed, 62, k]).integers(2**62, size=count)
        wanted = {"all": count, group: count, "first": FIRST}.get(part, 0)
        for i in range(wanted):
            flaw = FLAWS[(i + i // 3) % 3]
            found[f"{group[0]}{i:03d}"] = ArmPlan(group, ARMS[i % 3], bool(i // 3 % 2), flaw, int(seeds[i]))
    return found
