"""Forces planted in a regime are told to be there, noise is throughout."""

import numpy as np
import pytest

from estexp_jax.discovery.force_residual import ForceResidual
from estexp_jax.discovery.regime import THROUGHOUT, located_joint, regime
from tests.discovery.planted import nominal

ROBOT = nominal("two")


def moved(seed: int, force) -> ForceResidual:
    """A recording in which the elbow lacks `force(q, w, load)`, seen with some noise."""
    rng, time = np.random.default_rng(seed), np.arange(800) / 100.0
    frequency, phase = rng.uniform(0.3, 1.2, (3, 1)), rng.uniform(0.0, 6.3, (3, 1))
    q = np.sin(2.0 * np.pi * frequency * time + phase).sum(axis=0)
    w = np.gradient(q, time)
    load = np.sin(2.0 * np.pi * 0.23 * time + phase[0]) + 0.5 * np.sin(2.0 * np.pi * 0.71 * time + phase[1])
    both = [np.stack([np.zeros(800), x], axis=1) for x in (q, w, load, force(q, w, load))]
    both[3] = both[3] + 0.05 * rng.standard_normal((800, 2))
    return ForceResidual(time, both[0], both[1], both[2], both[2], both[3], both[2], both[2], np.ones((800, 2)))


LAWS = {
    "at high speed of elbow": lambda q, w, load: -0.1 * np.abs(w) * w,
    "under load of elbow": lambda q, w, load: -0.5 * np.abs(load) ** 2 * np.sign(w),
    "in the positive direction of elbow": lambda q, w, load: -0.5 * (w > 0.0),
    "in the negative direction of elbow": lambda q, w, load: -0.5 * (w < 0.0),
    "at reversals of elbow": lambda q, w, load: 0.5 * np.exp(-((w / 0.4) ** 2)),
    "throughout": lambda q, w, load: -0.5 * np.sign(w),
}


@pytest.mark.parametrize("words", LAWS)
def test_a_law_is_found_in_its_regime(words):
    assert regime(ROBOT, [moved(s, LAWS[words]) for s in (1, 2, 3)], "elbow", 0) == words


def test_a_range_is_told_with_its_unit():
    found = regime(ROBOT, [moved(s, lambda q, w, load: 1.0 * (q > 1.6)) for s in (1, 2, 3)], "elbow", 0)
    low, high = float(found.split()[1]), float(found.split()[3])
    assert found.endswith("rad of elbow") and 1.5 < low < 2.0 < high


def test_noise_has_no_regime():
    alarms = [regime(ROBOT, [moved(10 * s, lambda q, w, load: 0.0 * q)], "elbow", s) for s in range(20)]
    assert sum(a != THROUGHOUT for a in alarms) <= 2


def test_the_joint_is_that_of_the_place():
    seen = [moved(1, LAWS["throughout"])]
    assert located_joint(ROBOT, seen, [{"kind": "joint", "name": "shoulder"}]) == "shoulder"
    assert located_joint(ROBOT, seen, [{"kind": "body", "name": "lower"}]) == "elbow"
    assert located_joint(ROBOT, seen, [{"kind": "sensor", "name": "upper_angle"}]) == "shoulder"
    for kind in ("environment", "numerics"):
        assert located_joint(ROBOT, seen, [{"kind": kind, "name": None}]) == "elbow"
    assert located_joint(ROBOT, seen, []) == located_joint(ROBOT, seen, [{"kind": "actuator", "name": "*"}]) == "elbow"
