"""Windows follow each other without overlap and hold every row."""

import numpy as np
import pytest

from estexp_jax.estimation.windows import fitting_window, window_rows, windows_of
from estexp_jax.physics.model.robot import Robot


@pytest.mark.parametrize("length", [0.5, 0.73, 2.0, 9.0])
@pytest.mark.parametrize("seed", range(3))
def test_every_row_lies_in_one_window_no_longer_than_asked(length, seed):
    time = 3.0 + np.cumsum(np.random.default_rng(seed).uniform(0.002, 0.03, 300))
    windows = window_rows(time, length)
    assert np.concatenate([np.arange(a, b + 1) for a, b in windows]).tolist() == list(range(300))
    assert all(b > a for a, b in windows)
    assert all(time[b] - time[a] <= length + 0.03 for a, b in windows)


def test_windows_of_an_even_clock_have_equal_rows_and_begin_at_whole_lengths():
    time = 0.1 + np.arange(1000) * 0.01  # not exact in binary
    assert window_rows(time, 2.0) == [(200 * k, 200 * k + 199) for k in range(5)]


def test_a_lone_last_row_joins_the_window_before():
    assert window_rows(np.arange(201) / 100.0, 1.0) == [(0, 99), (100, 200)]


def test_a_lone_first_row_joins_the_window_after():
    time = np.arange(201) / 100.0
    assert window_rows(time, 1.0, cut=0.005) == [(0, 99), (100, 200)]
    assert window_rows(np.array([0.0, 1.5, 3.0, 3.1]), 1.0) == [(0, 1), (2, 3)]


def test_a_clock_of_one_row_is_one_window():
    assert window_rows(np.array([4.0]), 1.0) == [(0, 0)]


def test_an_infinite_window_is_the_whole_recording():
    assert window_rows(np.arange(50) / 10.0, np.inf) == [(0, 49)]


def test_a_gap_longer_than_a_window_leaves_no_empty_window():
    time = np.concatenate([np.arange(100) / 100.0, 5.0 + np.arange(100) / 100.0])
    assert window_rows(time, 1.0) == [(0, 99), (100, 199)]


def test_segments_start_at_their_own_first_row(mixed, blank):
    time = np.arange(250) / 100.0
    recordings = [blank(time, f"{k}.csv", sensor={3: (k + 1.0) * time**2}) for k in range(2)]
    segments = windows_of([mixed, mixed], recordings, 1.0)
    assert [(s.recording, s.first, s.last) for s in segments] == [
        (r, a, b) for r in range(2) for a, b in ((0, 99), (100, 199), (200, 249))
    ]
    for s in segments:
        begin = time[s.first]
        assert s.start.qpos[0] == pytest.approx((s.recording + 1.0) * begin**2, abs=1e-9)
        assert s.start.qvel[0] == pytest.approx(2.0 * (s.recording + 1.0) * begin, abs=1e-7)
        assert s.steps.start[0] == begin


def test_a_finer_segment_has_as_many_times_the_steps(mixed, blank):
    recordings = [blank(np.arange(51) / 50.0, sensor={3: np.zeros(51)})]
    [coarse], [fine] = (windows_of([mixed], recordings, np.inf, finer) for finer in (1, 4))
    assert fine.steps.n_steps == 4 * coarse.steps.n_steps
    assert fine.steps.sample.tolist() == (4 * coarse.steps.sample).tolist()


FLOATING = """
<mujoco>
  <default><geom contype="{touches}" conaffinity="{touches}"/></default>
  <worldbody>
    <geom type="plane" size="5 5 0.1"/>
    <body pos="0 0 1"><freejoint/><geom size="0.1"/></body>
  </worldbody>
</mujoco>
"""


def test_robots_that_touch_the_ground_are_fitted_in_short_windows():
    feet, ghost = (Robot.from_string(FLOATING.format(touches=n), "floating.xml") for n in (1, 0))
    assert fitting_window(feet, 2.0) == fitting_window(feet, np.inf) < 0.5
    assert fitting_window(feet, 0.2) == 0.2
    assert fitting_window(ghost, 2.0) == 2.0
