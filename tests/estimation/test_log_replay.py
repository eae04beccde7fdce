"""Pieces of a log, replayed: noise alone makes the error that is foretold, and versions go through in one batch."""

from dataclasses import replace

import numpy as np
import pytest

from estexp_jax.estimation.log_replay import log_replay_of
from estexp_jax.physics.model.robot import Robot
from tests.estimation.two_links import arm, log_of


@pytest.mark.parametrize("motor", ["position", "motor"])
def test_noise_alone_makes_the_error_that_is_foretold(motor):
    replay = log_replay_of(arm(motor), log_of(arm(motor)))
    assert replay is not None
    [error] = replay.errors([log_of(arm(motor))])
    assert 0.3 * replay.floor < error < 2.0 * replay.floor


def test_versions_and_models_go_through_together():
    recording = log_of(arm())
    replay = log_replay_of(arm(), recording)
    exchanged = replace(recording, sensor=recording.sensor[:, ::-1])
    assert replay is not None
    together = replay.errors([recording, exchanged, recording], [arm().model, arm().model, arm(mass=0.8).model])
    assert together[0] < 0.2 * together[2] < together[1]
    np.testing.assert_allclose(replay.errors([exchanged]), together[1])


def test_pieces_with_a_motor_off_do_not_count():
    recording = log_of(arm())
    enable = np.where(np.arange(recording.rows)[:, None] < recording.rows // 2, 0.0, 1.0) * np.ones((1, 2))
    replay = log_replay_of(arm(), recording)
    assert replay is not None
    half = replay.residuals([replace(recording, enable=enable)])[0]
    assert np.isnan(half[0]).all() and np.isfinite(half[-1]).all()


def test_joints_that_nothing_measures_or_that_stand_still_cannot_be_replayed():
    recording = log_of(arm())
    for column in (np.nan, 0.1):
        sensor = recording.sensor.copy()
        sensor[:, 0] = column
        assert log_replay_of(arm(), replace(recording, sensor=sensor)) is None
    free = Robot.from_string("<mujoco><worldbody><body><freejoint/><geom size='.1'/></body></worldbody></mujoco>")
    assert log_replay_of(free, recording) is None
