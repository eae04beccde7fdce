"""Start states on motions that are known."""

import numpy as np
import pytest

from estexp_jax.estimation.initial_state import estimate_motion

CLOCKS = {
    "even": np.arange(200) / 100.0,
    "uneven": np.cumsum(np.random.default_rng(41).uniform(0.002, 0.018, 200)),
    "slow": np.arange(60) / 20.0,
}


def cubic(t):
    return 0.3 - 1.2 * t + 0.8 * t**2 + 0.5 * t**3, -1.2 + 1.6 * t + 1.5 * t**2


@pytest.mark.parametrize("clock", CLOCKS)
@pytest.mark.parametrize("where", [0, 1, 30, -2, -1])
def test_a_smooth_motion_is_read_inside_and_at_the_ends(mixed, blank, clock, where):
    time = CLOCKS[clock]
    row = range(len(time))[where]
    position, speed = cubic(time)
    motion = estimate_motion(mixed, blank(time, sensor={3: position}, qpos={1: -position}))
    start = motion.state_at(row)
    assert start.qpos[:2] == pytest.approx([position[row], -position[row]], abs=1e-4)
    assert start.qvel[:2] == pytest.approx([speed[row], -speed[row]], abs=2e-2)
    assert start.sensed == ((3, 0, 0),)
    assert start.covariance is not None
    assert start.covariance[:2, 1, 1] == pytest.approx(0.0, abs=1e-2)
    assert not start.covariance[2:].any()


def test_columns_count_before_sensors_and_measured_speeds_before_slopes(mixed, blank):
    time = CLOCKS["even"]
    position, speed = cubic(time)
    rng = np.random.default_rng(42)
    shaky = position + 0.02 * rng.standard_normal(len(time))
    recording = blank(time, sensor={3: position + 9.0, 4: speed}, qpos={0: shaky, 1: 5.0 * time}, qvel={0: speed})
    start = estimate_motion(mixed, recording).state_at(40)
    assert start.qpos[0] == pytest.approx(position[40], abs=0.02)
    assert start.qpos[1] == pytest.approx(5.0 * time[40], abs=1e-4)
    assert start.qvel[0] == pytest.approx(speed[40], abs=1e-3)
    assert start.sensed == ()


def test_gaps_are_bridged_and_what_nothing_measured_is_at_home_and_at_rest(mixed, blank):
    time = CLOCKS["even"]
    position, speed = cubic(time)
    position = np.where(np.arange(200) % 3 == 0, np.nan, position)
    start = estimate_motion(mixed, blank(time, sensor={3: position})).state_at(60)
    assert start.qvel[0] == pytest.approx(speed[60], abs=1e-2)
    assert (start.qpos[1], start.qvel[1]) == (0.0, 0.0)
    assert start.qpos[2:] == pytest.approx(mixed.home()[2:])


def test_a_speed_without_a_position_is_smoothed_alone(mixed, blank):
    time = CLOCKS["even"]
    _, speed = cubic(time)
    noisy = speed + 0.01 * np.random.default_rng(43).standard_normal(len(time))
    start = estimate_motion(mixed, blank(time, qvel={0: noisy})).state_at(100)
    assert start.qpos[0] == mixed.home()[0]
    assert start.qvel[0] == pytest.approx(speed[100], abs=0.01)
    assert start.covariance is not None
    assert 0.0 < start.covariance[0, 1, 1] < 1e-4 and start.covariance[0, 0, 0] == 0.0


def test_a_single_sample_is_a_position_at_rest(mixed, blank):
    lone = np.full(200, np.nan)
    lone[61] = 0.7
    start = estimate_motion(mixed, blank(CLOCKS["even"], sensor={3: lone})).state_at(60)
    assert start.qpos[0] == pytest.approx(0.7) and start.qvel[0] == pytest.approx(0.0)


def test_a_free_joint_is_smoothed_through_gaps_and_flipped_quaternions(mixed, blank):
    time = CLOCKS["even"]
    angle = 1.5 * time
    pose = [1.0 + time, 0 * time, 2.0 + 0 * time, np.cos(angle / 2), 0 * time, 0 * time, np.sin(angle / 2)]
    recording = blank(time, qpos={2 + k: v for k, v in enumerate(pose)})
    recording.qpos[100:, 5:9] *= -1.0
    recording.qpos[48:52, 4] = np.nan
    start = estimate_motion(mixed, recording).state_at(50)
    assert start.qpos[2:5] == pytest.approx([1.0 + time[50], 0.0, 2.0], abs=1e-4)
    assert np.linalg.norm(start.qpos[5:9]) == pytest.approx(1.0)
    assert start.qpos[5:9] == pytest.approx([np.cos(angle[50] / 2), 0.0, 0.0, np.sin(angle[50] / 2)], abs=1e-4)
    assert start.qvel[2:] == pytest.approx([1.0, 0.0, 0.0, 0.0, 0.0, 1.5], abs=2e-2)


def test_measured_speeds_of_a_free_joint_count(mixed, blank):
    time = CLOCKS["even"]
    pose = [time, 0 * time, 0 * time, 1 + 0 * time, 0 * time, 0 * time, 0 * time]
    twist = [1.0 + 0 * time, 0 * time, 0 * time, 0.2 + 0 * time, 0 * time, -0.3 + 0 * time]
    recording = blank(time, qpos={2 + k: v for k, v in enumerate(pose)}, qvel={2 + k: v for k, v in enumerate(twist)})
    start = estimate_motion(mixed, recording).state_at(50)
    assert start.qvel[2:] == pytest.approx([1.0, 0.0, 0.0, 0.2, 0.0, -0.3], abs=1e-3)
