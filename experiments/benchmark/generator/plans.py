"""Which cases a set has: how many of each group, on which robots, with what concealed. Only the seed decides."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from experiments.benchmark.generator.case import Case, Plan, Planted, stronger
from experiments.benchmark.generator.catalogue import ABSORBABLE, MASKED, RELATIVES, SINGLE, UNKNOWN, places
from experiments.benchmark.generator.making import make
from experiments.benchmark.generator.robots import ROBOTS

SHARES = {
    "null": 0.22,
    "parameters": 0.14,
    "single": 0.32,
    "relative": 0.06,
    "unknown": 0.06,
    "pair": 0.04,
    "masked": 0.04,
    "onset": 0.04,
    "hidden": 0.04,
    "absorbed": 0.04,
}
"""Share of each group in a set."""
WEAKEST, PLAINEST = 0.03, 0.7
_HIDEABLE = ("viscous_friction", "quadratic_drag", "joint_limit", "armature", "torque_saturation")
_BEGINNING = (
    "coulomb_friction",
    "viscous_friction",
    "motor_weakness",
    "command_delay",
    "sensor_bias",
    "body_mass",
    "backlash",
)
_BEYOND = ("torque_saturation", "joint_limit", "cubic_spring")
"""What grows steeply beyond the training amplitude, so is often absorbed."""
_TRIES = 6


def counts(n: int) -> dict[str, int]:
    """Cases of each group in a set of n, by largest remainder."""
    exact = {g: s * n for g, s in SHARES.items()}
    found = {g: int(x) for g, x in exact.items()}
    for g in sorted(exact, key=lambda g: found[g] - exact[g])[: n - sum(found.values())]:
        found[g] += 1
    return found


def plans(seed: int, n: int, robots: Sequence[str]) -> list[Plan]:
    """The plans of a set, in an order that tells nothing."""
    rng = np.random.default_rng([seed, 0])
    found: list[Plan] = []
    for group, count in counts(n).items():
        found += list(_group(group, count, robots, rng))
    return [replace(found[i], seed=int(rng.integers(2**62))) for i in rng.permutation(len(found))]


def _group(group: str, count: int, robots: Sequence[str], rng: np.random.Generator) -> Iterator[Plan]:
    pools = {
        "single": [(e,) for e in SINGLE],
        "relative": [(e,) for e in RELATIVES],
        "unknown": [(e,) for e in UNKNOWN],
        "masked": list(MASKED),
        "onset": [(e,) for e in _BEGINNING],
        "hidden": [(e,) for e in _HIDEABLE],
        "absorbed": [(e,) for e in ABSORBABLE],
    }
    pool = [names for names in pools.get(group, [()]) if any(_fit(names, r) for r in robots)]
    order = [pool[i] for _ in range(count) for i in rng.permutation(len(pool))]
    for k in range(count):
        if group == "pair":
            names = tuple(str(e) for e in rng.choice(SINGLE, 2, replace=False))
            while not any(_fit(names, r) for r in robots):
                names = tuple(str(e) for e in rng.choice(SINGLE, 2, replace=False))
        else:
            names = order[k]
        robot = str(rng.choice([r for r in robots if _fit(names, r)]))
        planted = _planted(names, robot, group == "masked", rng)
        by_hand = (
            ROBOTS[robot].by_hand and not {"external_force", "part_lost"} & set(names) and bool(rng.random() < 0.5)
        )
        yield Plan(group, robot, planted, 0, by_hand)


def _fit(names: Sequence[str], robot: str) -> bool:
    return all(places(name, robot) for name in names)


def _planted(names: Sequence[str], robot: str, together: bool, rng: np.random.Generator) -> tuple[Planted, ...]:
    found: list[Planted] = []
    for name in names:
        fitting = places(name, robot)
        joint = int(rng.choice(fitting))
        if together and found and found[0].joint in fitting:
            joint = found[0].joint
        low = 0.15 if len(names) > 1 else WEAKEST
        strength = float(np.exp(rng.uniform(np.log(low), np.log(PLAINEST))))
        if name == "command_delay" and not together and rng.random() < 0.3:
            joint = -1
        found.append(Planted(name, joint, strength))
    return tuple(found)


def realised(plan: Plan, shorter: float = 1.0) -> Case:
    """The case of a plan; those that must be hidden or absorbed are drawn anew until they are, or given up.

    Hidden: weaker until training recordings show less than a floor. Absorbed: a refit within 60 % leaves at most 1.2
    floors in training, and at least 3 in the test recordings; scores count only those that are.
    """
    if plan.group not in ("hidden", "absorbed"):
        return make(plan, shorter=shorter)
    rng, case = np.random.default_rng([plan.seed, 2]), None
    for attempt in range(_TRIES):
        if plan.group == "hidden":
            case = make(plan, shorter=shorter)
            if case.visible.refit["train"] < 1.0:
                break
            plan = stronger(plan, 0.4)
        else:
            strength = float(np.exp(rng.uniform(np.log(0.05), np.log(PLAINEST))))
            wanted = _BEYOND if rng.random() < 0.6 else ABSORBABLE
            name = str(rng.choice([e for e in wanted if places(e, plan.robot)]))
            joint = int(rng.choice(places(name, plan.robot)))
            plan = replace(plan, planted=(Planted(name, joint, strength),), seed=plan.seed + attempt)
            case = make(plan, shorter=shorter, bound=0.6)
            if case.visible.refit["train"] <= 1.2 and case.visible.refit["test"] >= 3.0:
                break
    assert case is not None
    return case
