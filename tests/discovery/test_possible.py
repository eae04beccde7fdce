"""A sensor that moves is not stuck, one that holds still but for its noise may be; half a wave is no cogging yet."""

import numpy as np
import pytest

from estexp_jax.discovery.hypotheses import claiming, parameters_only
from estexp_jax.discovery.possible import conceivable, possible, still_throughout
from estexp_jax.discovery.slopes import Fit
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import catalogue
from tests.discovery.planted import Plant, case_of, nominal

STUCK = ("sensor_stuck", "angle")


@pytest.mark.parametrize(("first", "noise", "wanted"), [(0, 0.0, True), (150, 3e-4, True), (0, 0.02, True)])
def test_a_sensor_that_holds_still_may_be_stuck(first, noise, wanted):
    recordings = case_of("one", Plant(), 411).recordings
    for i, r in enumerate(recordings):
        left = r.rows - first
        r.sensor[first:, 0] = 0.4 + noise * np.random.default_rng(i).standard_normal(left)
    assert possible(nominal("one"), STUCK, recordings) is wanted


@pytest.mark.parametrize(("first", "wanted"), [(0, True), (150, False)])
def test_a_sensor_may_hold_still_from_the_start_or_from_later_on(first, wanted):
    recordings = case_of("one", Plant(), 415).recordings
    for r in recordings:
        r.sensor[first:, 0] = 0.4
    assert still_throughout(nominal("one"), "angle", recordings) is wanted


def test_a_sensor_that_moves_is_not_stuck():
    recordings = case_of("one", Plant(), 412).recordings
    assert not possible(nominal("one"), STUCK, recordings)
    drifting = case_of("one", Plant(), 413).recordings
    for r in drifting:
        r.sensor[:, 0] = 0.1 * r.time
    assert not possible(nominal("one"), STUCK, drifting)
    assert possible(nominal("one"), ("sensor_bias", "angle"), drifting)


def test_only_training_recordings_have_a_say():
    recordings = case_of("one", Plant(), 414).recordings
    for r in recordings:
        if r.role == "train":
            r.sensor[:, 0] = -0.2
    assert possible(nominal("one"), STUCK, recordings)


@pytest.mark.parametrize(("n", "wanted"), [(16.0, False), (20.0, True)])
def test_cogging_of_which_less_than_two_waves_were_seen_is_not_conceivable(n, wanted):
    robot = nominal("one")
    own = parameters_only(robot, catalogue(["viscous_friction"]))
    place = "cogging", "shaft"
    hypothesis = claiming(robot, own, [place])
    fitted = Fit(hypothesis, hypothesis.with_values(place, (0.2, n, 0.0)), 1.0)
    seen = Observed(np.array([-0.3]), np.array([0.4]), np.full(1, np.nan))
    assert conceivable(robot, fitted, seen) is wanted
    assert conceivable(robot, Fit(own, own.start(), 1.0), seen), "nothing is claimed"
