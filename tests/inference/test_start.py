"""Start states on motions that are known."""

import numpy as np
import pytest

from estexp_jax.inference.start import start_state

CLOCKS = {
    "even": np.arange(200) / 100.0,
    "uneven": np.cumsum(np.random.default_rng(41).uniform(0.002, 0.018, 200)),
    "slow": np.arange(60) / 20.0,
}


def cubic(t):
    return 0.3 - 1.2 * t + 0.8 * t**2 + 0.5 * t**3, -1.2 + 1.6 * t + 1.5 * t**2


@pytest.mark.parametrize("clock", CLOCKS)
@pytest.mark.parametrize("where", [0, 1, 30, -2, -1])
def test_a_cubic_is_read_exactly_inside_and_at_the_ends(mixed, blank, clock, where):
    time = CLOCKS[clock]
    row = range(len(time))[where]
    position, speed = cubic(time)
    start = start_state(mixed, blank(time, sensor={3: position}, qpos={1: -position}), row)
    assert start.qpos[:2] == pytest.approx([position[row], -position[row]], abs=1e-9)
    assert start.qvel[:2] == pytest.approx([speed[row], -speed[row]], abs=1e-7)
    assert start.sensed == ((3, 0, 0),)


def test_a_parabola_needs_only_degree_two(mixed, blank):
    time = CLOCKS["uneven"]
    start = start_state(mixed, blank(time, sensor={3: 1.0 - 2.0 * time**2}), 50, degree=2)
    assert start.qpos[0] == pytest.approx(1.0 - 2.0 * time[50] ** 2)
    assert start.qvel[0] == pytest.approx(-4.0 * time[50])


def test_a_jolting_servo_is_read_within_a_tenth_of_its_speed(mixed, blank):
    time = np.arange(300) / 100.0
    position, speed = np.sin(9.0 * time), 9.0 * np.cos(9.0 * time)
    noise = 5e-4 * np.random.default_rng(42).standard_normal(len(time))
    recording = blank(time, sensor={3: position + noise})
    found = np.array([start_state(mixed, recording, row).qvel[0] for row in range(10, 290)])
    assert np.sqrt(np.mean((found - speed[10:290]) ** 2)) < 0.15


def test_columns_count_before_sensors_and_measured_speeds_before_slopes(mixed, blank):
    time = CLOCKS["even"]
    position, speed = cubic(time)
    recording = blank(
        time, sensor={3: position + 9.0, 4: speed}, qpos={0: position, 1: 5.0 * time}, qvel={0: 2.0 * speed}
    )
    start = start_state(mixed, recording, 40)
    assert start.qpos[:2] == pytest.approx([position[40], 5.0 * time[40]])
    assert start.qvel[:2] == pytest.approx([2.0 * speed[40], speed[40]])
    assert start.sensed == ()


def test_gaps_are_bridged_and_what_nothing_measured_is_at_home_and_at_rest(mixed, blank):
    time = CLOCKS["even"]
    position, speed = cubic(time)
    position = np.where(np.arange(200) % 3 == 0, np.nan, position)
    start = start_state(mixed, blank(time, sensor={3: position}), 60)
    assert start.qvel[0] == pytest.approx(speed[60], abs=1e-6)
    assert (start.qpos[1], start.qvel[1]) == (0.0, 0.0)
    assert start.qpos[2:] == pytest.approx(mixed.home()[2:])


def test_a_single_sample_is_a_position_at_rest(mixed, blank):
    lone = np.full(200, np.nan)
    lone[61] = 0.7
    start = start_state(mixed, blank(CLOCKS["even"], sensor={3: lone}), 60)
    assert (start.qpos[0], start.qvel[0]) == (0.7, 0.0)


def test_a_free_joint_takes_the_nearest_whole_sample_with_a_unit_quaternion(mixed, blank):
    time = CLOCKS["even"]
    pose = [1.0 + time, 0 * time, 2.0 + 0 * time, 2.0 + 0 * time, 0 * time, 0 * time, 2.0 * time]
    twist = [0 * time + k for k in range(6)]
    recording = blank(time, qpos={2 + k: v for k, v in enumerate(pose)}, qvel={2 + k: v for k, v in enumerate(twist)})
    recording.qpos[48:52, 4] = np.nan
    start = start_state(mixed, recording, 50)
    assert start.qpos[2] in (1.0 + time[47], 1.0 + time[52])
    assert np.linalg.norm(start.qpos[5:9]) == pytest.approx(1.0)
    assert start.qpos[8] / start.qpos[5] == pytest.approx(start.qpos[2] - 1.0)
    assert start.qvel[2:] == pytest.approx(range(6))
