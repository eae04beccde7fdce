"""Properties of single signals, against signals made to have them."""

import numpy as np
import pytest

from estexp_jax.recordings.checks import signals

TIME = np.arange(1000) * 0.01


def test_encoder_step_is_found_in_rounded_values_only():
    wave = np.sin(TIME)
    assert signals.encoder_step(np.round(wave / 0.02) * 0.02) == pytest.approx(0.02)
    assert signals.encoder_step(wave) == 0.0
    assert signals.encoder_step(np.zeros(50)) == 0.0


def test_repeats_are_counted_while_the_signal_moves():
    fast = np.sin(5 * TIME)
    held = fast[(np.arange(1000) // 4) * 4]
    assert signals.repeats(held, 0.0) == pytest.approx(0.75, abs=0.02)
    assert signals.repeats(fast, 0.0) == 0.0
    assert signals.repeats(np.zeros(1000), 0.0) == 0.0


def test_runs_are_the_longest_stretches_of_equal_samples():
    values = np.array([1.0, 1.0, 2.0, 3.0, 3.0, 3.0])
    assert signals.runs(values, 2) == [signals.Run(0, 2), signals.Run(3, 3)]
    assert signals.runs(values, 3)[0].stop == 6


def test_a_clipped_signal_is_cut_at_speed_and_a_slow_one_turns():
    end, share = signals.clipped(np.minimum(np.sin(3 * TIME), 0.7))
    assert end == 0.7 and 0.1 < share < 0.4
    assert signals.clipped(np.sin(3 * TIME))[1] == 0.0


def test_spikes_jump_away_and_back():
    values = np.sin(TIME)
    values[[200, 500]] += 3.0
    assert signals.spikes(values, 0.0).tolist() == [200, 500]
    assert not len(signals.spikes(np.sin(TIME), 0.0))


def test_the_lag_of_a_delayed_signal_is_its_delay():
    delay, best, without = signals.lag(TIME, np.sin(3 * TIME), np.sin(3 * (TIME - 0.2)))
    assert delay == pytest.approx(0.2, abs=0.011) and best > 0.999 > without
    assert signals.lag(TIME, np.sin(3 * (TIME - 0.2)), np.sin(3 * TIME))[0] == pytest.approx(-0.2, abs=0.011)


def test_speed_is_the_slope():
    np.testing.assert_allclose(signals.speed(TIME, 2.0 * TIME), 2.0)
    np.testing.assert_allclose(signals.speed(TIME[:2], np.array([0.0, 0.03])), 3.0)


def test_turns_count_swings_above_a_size():
    wave = np.sin(2 * np.pi * TIME)
    assert signals.turns(wave, 0.5) == 20 and signals.turns(wave, 3.0) == 0
