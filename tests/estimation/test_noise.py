"""The noise floor is what was put in, whatever the motion."""

import numpy as np
import pytest

from estexp_jax.estimation.accuracy import nrmse
from estexp_jax.estimation.channels import channel_ranges, channels_of
from estexp_jax.estimation.noise import correlation_rows, noise_floor
from estexp_jax.physics.reading_noise import noise_std_of


def motion(time):
    return np.sin(2.0 * np.pi * 0.8 * time) + 0.4 * np.sin(2.0 * np.pi * 2.1 * time + 1.0)


@pytest.mark.parametrize("deviation", [1e-3, 1e-2])
def test_white_noise_on_a_motion_is_measured(deviation):
    time = np.arange(4000) / 200.0
    noise = deviation * np.random.default_rng(31).standard_normal(len(time))
    assert noise_std_of(time, motion(time) + noise) == pytest.approx(deviation, rel=0.1)


def test_a_fast_motion_on_a_slow_uneven_clock_is_not_noise():
    rng = np.random.default_rng(37)
    time = np.arange(800) / 50.0 + 1.5e-3 * rng.standard_normal(800)
    noise = 3e-4 * rng.standard_normal(len(time))
    assert noise_std_of(time, motion(time) + noise) == pytest.approx(3e-4, rel=0.15)


def test_jolts_count_little():
    time = np.arange(4000) / 200.0
    noise = 1e-3 * np.random.default_rng(32).standard_normal(len(time))
    jolts = np.repeat(np.random.default_rng(33).uniform(-1.0, 1.0, 40), 100)
    assert noise_std_of(time, motion(time) + noise + jolts) == pytest.approx(1e-3, rel=0.15)


def test_an_encoders_steps_are_noise_even_at_rest():
    step = 2.0 * np.pi / 4096
    read = np.round(0.05 * motion(np.arange(4000) / 200.0) / step) * step
    assert noise_std_of(np.arange(4000) / 200.0, read) == pytest.approx(step / np.sqrt(12.0), rel=0.35)
    resting = np.where(np.arange(400) == 200, step, 0.0)
    assert noise_std_of(np.arange(400) / 200.0, resting) == pytest.approx(step / np.sqrt(12.0))


def test_gaps_are_passed_over_and_few_samples_say_nothing():
    noise = 1e-2 * np.random.default_rng(34).standard_normal(2000)
    noise[np.random.default_rng(35).random(2000) < 0.2] = np.nan
    assert noise_std_of(np.arange(2000) / 200.0, noise) == pytest.approx(1e-2, rel=0.1)
    assert np.isnan(noise_std_of(np.arange(5.0), np.array([1.0, np.nan, 2.0, 3.0, 4.0])))


def test_the_floor_is_the_error_of_a_perfect_simulator(mixed, blank):
    rng, time = np.random.default_rng(36), np.arange(3000) / 200.0
    truths = [3.0 * motion(time), 0.2 * motion(1.3 * time)]
    recordings = [
        blank(time, sensor={3: truth + 0.01 * scale * rng.standard_normal(len(time)), 4: scale * truth})
        for scale, truth in zip((3.0, 0.2), truths, strict=True)
    ]
    channels = channels_of(mixed, recordings)
    perfect = []
    for recording, truth in zip(recordings, truths, strict=True):
        difference = channels.recorded(recording)[:, 0] - truth
        perfect.append(
            np.stack([difference, np.zeros(len(time))], axis=1) ** 2 / channel_ranges(channels, recording) ** 2
        )
    assert noise_floor(channels, recordings) == pytest.approx(nrmse(perfect), rel=0.1)
    assert noise_floor(channels, []) == 0.0


@pytest.mark.parametrize(("memory", "rows"), [(0.0, 1.0), (0.8, 9.0), (0.95, 39.0)])
def test_what_lasts_counts_as_fewer_samples(memory, rows):
    rng = np.random.default_rng(77)
    noise = rng.standard_normal((6, 4000, 2))
    for k in range(1, 4000):
        noise[:, k] += memory * noise[:, k - 1]
    assert correlation_rows(noise) == pytest.approx(rows, rel=0.2)


def test_no_residuals_last_for_no_time():
    assert correlation_rows(np.zeros((2, 50, 3))) == 1.0
