"""Faults of logging: what was put into a log is taken out of it again, and commands move in time exactly."""

from dataclasses import replace

import numpy as np
import pytest

from estexp_jax.physics.effects.changes import Change, parse_change
from estexp_jax.physics.effects.logging_fault import LoggingFault, is_even, with_commands_at
from estexp_jax.physics.effects.registry import effect, logging_faults
from tests.estimation.two_links import arm, faulty, log_of


def held(recording, at):
    """The commands in force at some times."""
    return recording.ctrl[np.searchsorted(recording.time, at, side="right") - 1]


def fault_of(change: Change) -> LoggingFault:
    found = effect(change.effect)
    assert isinstance(found, LoggingFault)
    return found


@pytest.mark.parametrize(
    "fault",
    [
        "channels_exchanged@q_shoulder with=q_elbow",
        "channels_exchanged@m_shoulder with=m_elbow",
        "clock_scale factor=1.1",
        "clock_scale@* factor=1.01",
        "command_lead lead=0.03",
    ],
)
def test_what_is_put_in_is_taken_out(fault):
    robot, right = arm(), log_of(arm())
    change = parse_change(fault, robot)
    wrong = faulty(robot, right, fault)
    back = fault_of(change).mended(robot, wrong, change.name or "", change.values)
    rows = np.flatnonzero(np.isfinite(back.sensor[:, 0]))
    np.testing.assert_allclose(back.time[rows], right.time, atol=1e-9)
    np.testing.assert_array_equal(back.sensor[rows], right.sensor)
    inside = np.arange(1.0, 6.0, 0.0137)
    assert np.abs(held(back, inside) - held(right, inside)).max() < 0.03
    assert not np.array_equal(wrong.sensor, right.sensor) or not np.array_equal(
        held(wrong, inside), held(right, inside)
    )


def test_a_reading_without_a_signal_is_taken_out_whole():
    robot = arm()
    for fault in ("no_signal@q_elbow std=0.3", "no_signal@q_elbow copy_of=m_elbow"):
        change = parse_change(fault, robot)
        back = fault_of(change).mended(robot, faulty(robot, log_of(arm()), fault), "q_elbow", change.values)
        assert np.isnan(back.sensor[:, 1]).all() and np.isfinite(back.sensor[:, 0]).all()


@pytest.mark.parametrize("shift", [0.0, 0.004, 0.006, -0.01, 0.0113])
def test_commands_move_by_half_rows_of_an_even_clock(shift):
    right = log_of(arm())
    moved = with_commands_at(right, right.time + shift)
    assert is_even(moved) and right.rows <= moved.rows <= 2 * right.rows
    late = held(moved, np.arange(1.0, 6.0, 0.1) + 1e-4)
    rounded = round(shift / 0.002) * 0.002
    np.testing.assert_array_equal(late, held(right, np.arange(1.0, 6.0, 0.1) + 1e-4 - rounded))


def test_commands_of_an_uneven_log_move_exactly():
    right = log_of(arm())
    time = right.time + np.random.default_rng(0).uniform(0.0, 0.003, right.rows)
    uneven = replace(right, time=time)
    moved = with_commands_at(uneven, time + 0.0127)
    at = np.arange(1.0, 6.0, 0.0137)
    np.testing.assert_array_equal(held(moved, at), held(uneven, at - 0.0127))
    assert np.isfinite(moved.sensor[:, 0]).sum() == uneven.rows


def test_each_is_of_the_recording_and_no_search_simulates_it():
    from estexp_jax.discovery.diagnosis import explaining
    from estexp_jax.discovery.hypotheses import simulated

    names = {e.name for e in logging_faults()}
    assert names <= set(explaining()) and not names & set(simulated(explaining()))
    assert {(e.kind, e.side) for e in logging_faults()} == {("recording", "sensor")}
