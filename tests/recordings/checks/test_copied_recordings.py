"""A recording that repeats another, in whole or in part."""

from dataclasses import replace

import numpy as np

from estexp_jax.recordings.checks.copied_recordings import copied_recordings
from tests.estimation.two_links import arm, log_of

LOG = log_of(arm())


def rows_of(recording, first, last):
    tables = {
        name: getattr(recording, name)[first:last] for name in ("time", "ctrl", "enable", "sensor", "qpos", "qvel")
    }
    return replace(recording, **tables)


def test_recordings_of_their_own_are_none():
    assert not [*copied_recordings([LOG, log_of(arm(), seed=1), log_of(arm(), seed=2, role="test")])]


def test_a_test_that_was_fitted_is_told():
    [(index, fault)] = copied_recordings([LOG, replace(LOG, name="test.csv", role="test")])
    assert index == 1 and fault.kind == "copied_recording" and LOG.name in fault.sentence
    assert "proves nothing" in fault.sentence


def test_a_part_of_another_is_told_whatever_its_clock_says():
    part = rows_of(replace(LOG, time=LOG.time + 100.0, name="part.csv"), 500, 900)
    [(index, fault)] = copied_recordings([part, LOG])
    assert index == 1 and "count twice" in fault.sentence


def test_robots_at_rest_are_all_alike():
    still = replace(LOG, ctrl=0.0 * LOG.ctrl, sensor=np.zeros_like(LOG.sensor))
    assert not [*copied_recordings([still, replace(still, name="b.csv")])]
