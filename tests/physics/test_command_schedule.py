"""Steps end on every row, and commands are held and shifted exactly."""

import numpy as np
import pytest

from estexp_jax.physics.command_schedule import CommandHistory, command_before, physics_steps

UNEVEN = np.cumsum(np.random.default_rng(51).uniform(1e-4, 0.03, 120))


@pytest.mark.parametrize("timestep", [0.001, 0.004, 0.1])
def test_steps_end_on_every_row_and_are_no_longer_than_asked(timestep):
    found = physics_steps(UNEVEN, timestep)
    assert found.length.max() <= timestep * (1.0 + 2e-6)
    assert found.n_steps == len(found.length) == len(found.row)
    assert found.start[found.sample[:-1]] == pytest.approx(UNEVEN[:-1], abs=1e-15)
    assert found.sample[-1] == found.n_steps
    assert (found.start + found.length)[:-1] == pytest.approx(found.start[1:], abs=1e-12)
    assert found.start[-1] + found.length[-1] == pytest.approx(UNEVEN[-1])
    assert (np.diff(found.row) >= 0).all() and set(found.row) == set(range(119))


def test_the_steps_between_two_rows_are_equal():
    found = physics_steps(np.array([0.0, 0.01, 0.013]), 0.004)
    assert found.length == pytest.approx([0.01 / 3] * 3 + [0.003])


def test_whole_steps_stay_whole_in_spite_of_rounding():
    time = 1.7e5 + np.arange(400) * 0.01  # a clock that counts from long ago: 0.01 s is not exact
    found = physics_steps(time, 0.0025)
    assert set(np.diff(found.sample)) == {4} and set(found.length) == {0.0025}  # as MuJoCo steps, to the last bit


def held(time, ctrl, when):
    """The command in force at a moment."""
    return ctrl[max(np.searchsorted(time, when, side="right") - 1, 0)]


def test_without_delay_each_step_has_its_rows_command():
    ctrl = np.random.default_rng(52).standard_normal((120, 2))
    steps = physics_steps(UNEVEN, 0.004)
    found = CommandHistory(UNEVEN, ctrl).mean(steps.start, steps.length, np.zeros(2))
    assert np.array_equal(found, ctrl[steps.row])


@pytest.mark.parametrize("delay", [0.0013, 0.02, 0.5, 99.0])
def test_a_late_command_is_the_mean_of_what_was_in_force_then(delay):
    ctrl = np.random.default_rng(53).standard_normal((120, 2))
    steps = physics_steps(UNEVEN, 0.01)
    found = CommandHistory(UNEVEN, ctrl).mean(steps.start, steps.length, np.array([0.0, delay]))
    assert np.array_equal(found[:, 0], ctrl[steps.row, 0])
    for begin, length, value in list(zip(steps.start, steps.length, found[:, 1], strict=True))[::7]:
        moments = begin - delay + length * (np.arange(4000) + 0.5) / 4000
        assert value == pytest.approx(np.mean([held(UNEVEN, ctrl[:, 1], m) for m in moments]), abs=3e-3)


def test_until_the_first_row_the_command_before_counts():
    ctrl, before = np.array([[1.0], [2.0], [3.0]]), np.array([5.0])
    history = CommandHistory(np.array([0.0, 0.1, 0.2]), ctrl, before)
    moment, length = np.array([-0.01, 0.0]), np.array([0.01, 0.1])
    assert history.mean(moment, length, np.zeros(1)).tolist() == [[5.0], [1.0]]
    assert history.mean(moment, length, np.array([0.05]))[1] == pytest.approx(3.0)  # half of each
    assert history.with_commands(ctrl + 1.0).mean(moment, length, np.zeros(1)).tolist() == [[5.0], [2.0]]


def test_what_nobody_logged_came_as_smoothly_as_what_follows_if_the_robot_moves():
    ctrl = np.array([[0.1, 0.0, 1.0], [0.3, 0.0, 1.0], [0.52, 1.0, 1.0], [0.7, 1.0, 1.0]])
    moving = np.array([[1.0], [1.1], [0.9], [1.0]])
    assert command_before(ctrl, moving) == pytest.approx([-0.1, 0.0, 1.0])
    resting = moving * [[0.01], [1.0], [1.0], [1.0]]
    assert np.array_equal(command_before(ctrl, resting), ctrl[0])
    assert np.array_equal(command_before(ctrl[:2], moving[:2]), ctrl[0])


def test_the_mean_is_continuous_in_the_delay():
    ctrl = np.random.default_rng(54).standard_normal((120, 1))
    steps, history = physics_steps(UNEVEN, 0.01), CommandHistory(UNEVEN, ctrl)
    a, b = (history.mean(steps.start, steps.length, np.array([d])) for d in (0.02, 0.02 + 1e-7))
    assert np.abs(a - b).max() < 1e-2
