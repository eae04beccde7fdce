"""Lost rows come back with commands between their neighbours and no readings; nothing else changes."""

import numpy as np
import pytest

from estexp_jax.estimation.missing_commands import interpolation_error, with_missing_rows, with_other_commands


def test_lost_rows_come_back_where_the_clock_lacks_them(mixed, blank):
    whole = np.arange(60) / 50.0 + 1e-4 * np.random.default_rng(61).standard_normal(60)
    kept = np.delete(np.arange(60), [20, 40, 41])
    recording = blank(whole[kept], sensor={3: np.sin(whole[kept])})
    recording.ctrl[:] = np.linspace(0.0, 1.0, 60)[kept, None]
    found = with_missing_rows(recording)
    assert found.rows == 60
    np.testing.assert_allclose(found.time, whole, atol=1e-3)
    np.testing.assert_allclose(found.ctrl[:, 0], np.linspace(0.0, 1.0, 60), atol=1e-9)
    assert np.isnan(found.sensor[[20, 40, 41], 3]).all()
    np.testing.assert_array_equal(found.sensor[kept, 3], recording.sensor[:, 3])
    np.testing.assert_array_equal(found.time[kept], recording.time)


def test_an_uneven_clock_and_a_long_pause_stay_as_they_are(mixed, blank):
    rng = np.random.default_rng(62)
    uneven = blank(np.cumsum(rng.uniform(0.6, 1.4, 50)))
    assert with_missing_rows(uneven) is uneven
    paused = blank(np.concatenate([np.arange(20) / 50.0, 1.0 + np.arange(20) / 50.0]))
    assert with_missing_rows(paused) is paused


def test_lost_commands_go_on_as_before_or_lead_to_what_came_after(mixed, blank):
    rows, kept = np.arange(60), np.delete(np.arange(60), [20, 40, 41])
    before, after = 0.01 * rows, 0.5 + 0.02 * rows
    recording = blank(kept / 50.0)
    recording.ctrl[:] = np.where(rows < 20, before, after)[kept, None]
    found = with_missing_rows(recording)
    assert found.guessed is not None and set(np.flatnonzero(found.guessed)) == {20, 40, 41}
    for side, expected in ((-1, before[20]), (0, 0.5 * (before[19] + after[21])), (1, after[20])):
        changed = with_other_commands(found, np.full(60, side))
        assert changed.ctrl[20] == pytest.approx(expected)
        assert changed.ctrl[40] == pytest.approx(after[40])
        np.testing.assert_array_equal(changed.ctrl[kept], recording.ctrl)
    assert with_other_commands(recording, np.ones(57)) is recording


def test_lost_commands_are_as_uncertain_as_logged_ones_would_be(mixed, blank):
    kept = np.delete(np.arange(60), [20, 41])
    recording = blank(kept / 50.0)
    for ctrl, expected in ((np.where(kept % 2 == 0, 0.5, -0.5), 1.0), (0.1 * kept, 0.0)):
        recording.ctrl[:] = ctrl[:, None]
        assert interpolation_error(with_missing_rows(recording)) == pytest.approx([expected], abs=0.05)
    assert not interpolation_error(blank(np.arange(2) / 50.0)).any()
