"""Clocks of a log: rows before the first command, logs that begin anew, and two clocks that do not overlap."""

import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.recordings.clocks import check_overlap, first_command, longest_run, row_times, sampled_span
from estexp_jax.recordings.columns import Source
from estexp_jax.recordings.table import Table

NAN = np.nan


def _spans(**columns):
    spans = {name: sampled_span(name, np.array(t, float), np.array(v, float)) for name, (t, v) in columns.items()}
    return {name: span for name, span in spans.items() if span is not None}


@pytest.mark.parametrize(
    ("one", "two", "overlap"),
    [
        ((0.0, 8.0), (0.1, 8.1), True),
        ((0.0, 8.0), (8.5, 16.0), True),  # late, but perhaps by the same clock
        ((0.0, 8.0), (1.7e9, 1.7e9 + 8), False),
        ((1.7e9, 1.7e9 + 8), (312.0, 320.0), False),
        ((0.0, 8.0), (30.0, 38.0), False),
    ],
)
def test_two_clocks_must_overlap(one, two, overlap):
    spans = _spans(command=(one, (1, 2)), reading=(two, (1, 2)))
    if overlap:
        check_overlap(spans, "a.mcap")
    else:
        with pytest.raises(InputError, match=r'a\.mcap: the clocks of .* do not overlap; .*clock = "log"'):
            check_overlap(spans, "a.mcap")


def test_a_command_that_was_sent_once_may_come_long_before():
    check_overlap(_spans(command=((0.0,), (1.0,)), reading=((600.0, 610.0), (1, 2))), "a.mcap")
    with pytest.raises(InputError, match="do not overlap"):
        check_overlap(_spans(command=((0.0,), (1.0,)), reading=((1.7e9, 1.7e9 + 8), (1, 2))), "a.mcap")
    assert sampled_span("x", np.arange(2.0), np.full(2, NAN)) is None


def test_rows_before_the_first_command_of_every_actuator():
    time = np.arange(4) * 0.5
    commands = {"ctrl.a": np.array([1.0, NAN, 2.0, NAN]), "ctrl.b": np.array([NAN, NAN, 0.0, 0.0])}
    assert first_command(commands, time, "a.csv") == (2, "2 rows (1 s) before the first command of b are left out")
    assert first_command({"ctrl.a": commands["ctrl.a"]}, time, "a.csv") == (0, "")
    with pytest.raises(InputError, match=r"a\.csv: every command of ctrl\.a is empty"):
        first_command({"ctrl.a": np.full(4, NAN)}, time, "a.csv")


def test_the_longest_part_of_a_log_that_begins_anew():
    table = Table("a.csv", {"time": np.array([0.0, 1.0, 0.0, 1.0, 2.0]), "x": np.arange(5.0)}, restarts=(2,))
    part, note = longest_run(table, Source("time"))
    assert part.column("x").tolist() == [2.0, 3.0, 4.0] and "from a.csv, row 3" in note
    assert row_times(part, Source("time")).tolist() == [0.0, 1.0, 2.0]
    going_on = Table("a.csv", {"time": np.arange(5.0)}, restarts=(2,))
    assert longest_run(going_on, Source("time")) == (going_on, "")
