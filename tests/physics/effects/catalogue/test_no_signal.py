"""Readings that say nothing of the robot are seen in the log itself; those that do are left alone."""

from dataclasses import replace

import numpy as np
import pytest

from estexp_jax.physics.effects.catalogue.no_signal import NoSignal, is_noise
from tests.estimation.two_links import arm, faulty, log_of


def plain(recording, site="q_shoulder"):
    return NoSignal().plain(arm(), site, recording)


def test_a_right_log_has_signals():
    assert plain(log_of(arm())) is None and plain(log_of(arm()), "q_elbow") is None


@pytest.mark.parametrize("rows", [60, 400, 2000])
def test_noise_is_told_with_its_size(rows):
    recording = faulty(arm(), log_of(arm()), "no_signal@q_shoulder std=0.3")
    cut = {n: getattr(recording, n)[:rows] for n in ("time", "ctrl", "enable", "sensor", "qpos", "qvel")}
    assert plain(replace(recording, **cut)) == {"std": pytest.approx(0.3, rel=0.25), "copy_of": 0.0}


@pytest.mark.parametrize(("source", "number"), [("q_elbow", 2.0), ("m_shoulder", 3.0), ("m_elbow", 4.0)])
def test_a_copy_is_told_with_what_it_copies(source, number):
    recording = faulty(arm(), log_of(arm()), f"no_signal@q_shoulder copy_of={source}")
    assert plain(recording) == {"std": 0.0, "copy_of": number}
    assert plain(recording, "q_elbow") is None, "what is copied is right"


def test_the_command_of_the_row_before_is_a_copy_too():
    recording = log_of(arm())
    sensor = recording.sensor.copy()
    sensor[1:, 0] = recording.ctrl[:-1, 0]
    assert plain(replace(recording, sensor=sensor)) == {"std": 0.0, "copy_of": 3.0}


def test_a_joint_at_rest_may_be_noisy():
    recording = log_of(arm())
    sensor = recording.sensor.copy()
    sensor[:, 0] = np.random.default_rng(0).normal(0.2, 0.005, recording.rows)
    assert plain(replace(recording, sensor=sensor)) is None


def test_a_fast_motion_sampled_slowly_is_no_noise():
    assert not is_noise(np.sin(2.1 * np.arange(300.0))) and is_noise(np.random.default_rng(1).normal(size=300))
