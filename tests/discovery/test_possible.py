"""A sensor that moves is not stuck; one that holds still but for its noise may be."""

import numpy as np
import pytest

from estexp_jax.discovery.possible import possible, still_throughout
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
