"""Progress: a live line on a terminal, now and then a plain one elsewhere."""

import io
import time

import pytest

from estexp_jax.runs import ProgressDisplay
from estexp_jax.runs.progress import duration


class Terminal(io.StringIO):
    def isatty(self):
        return True


class Clock:
    now = 100.0

    def __call__(self):
        return self.now


@pytest.fixture
def streams():
    return {"out": io.StringIO(), "err": io.StringIO()}


def test_plain_lines_come_at_once_and_then_every_period(streams):
    clock = Clock()
    with ProgressDisplay(**streams, clock=clock) as progress:
        progress.stage("exploration 1/5", total=40)
        for _ in range(31):
            clock.now += 1.0
            progress.advance(1, note="best 3.2 m")
        progress.stage("estimation 1/4")
        clock.now += 9.5
        progress.advance(0.5)
    assert streams["err"].getvalue().splitlines() == [
        "exploration 1/5: 0/40, 0 s",
        "exploration 1/5: 10/40, 10 s, about 30 s left, best 3.2 m",
        "exploration 1/5: 20/40, 20 s, about 20 s left, best 3.2 m",
        "exploration 1/5: 30/40, 30 s, about 10 s left, best 3.2 m",
        "estimation 1/4: 0.5, 10 s",
    ]
    assert streams["out"].getvalue() == ""


def test_a_stage_may_fall_back(streams):
    clock = Clock()
    with ProgressDisplay(**streams, clock=clock) as progress:
        progress.stage("runs", total=4)
        for done in (2.5, 1.5, 4):
            clock.now += 10.0
            progress.reach(done, note="on 2 machines")
    assert [line.partition(",")[0] for line in streams["err"].getvalue().splitlines()] == [
        "runs: 0/4",
        "runs: 2.5/4",
        "runs: 1.5/4",
        "runs: 4/4",
    ]


def test_a_log_shows_life_where_nothing_is_reported(streams):
    with ProgressDisplay(**streams, period=0.02) as progress:
        progress.stage("compiling")
        deadline = time.monotonic() + 5.0
        while streams["err"].getvalue().count("compiling") < 3 and time.monotonic() < deadline:
            time.sleep(0.01)
    output = streams["err"].getvalue()
    assert output.count("compiling") >= 3
    time.sleep(0.1)
    assert streams["err"].getvalue() == output


def test_the_story_is_always_told_on_standard_output(capsys):
    with ProgressDisplay() as progress:
        progress.say("walks [3.2] m")
    assert capsys.readouterr().out == "walks [3.2] m\n"


def test_a_terminal_gets_a_live_line():
    out, err = Terminal(), io.StringIO()
    with ProgressDisplay(out=out, err=err) as progress:
        progress.stage("exploration 1/5", total=4)
        progress.say("walks [3.2] m")
        progress.stage("estimation [1/4]", total=4)
        progress.advance(3, note="best 3.2 m")
    output = out.getvalue()
    assert "exploration 1/5" in output and "walks [3.2] m\n" in output and "estimation [1/4]" in output
    assert "3/4" in output and "best 3.2 m" in output
    assert err.getvalue() == ""


def test_the_story_stays_clean_where_only_the_errors_go_to_a_terminal():
    out, err = io.StringIO(), Terminal()
    with ProgressDisplay(out=out, err=err) as progress:
        progress.stage("exploration", total=4)
        progress.say("walks")
    assert out.getvalue() == "walks\n"
    assert "exploration" in err.getvalue()


def test_a_step_needs_a_stage(streams):
    with ProgressDisplay(**streams) as progress, pytest.raises(RuntimeError, match="no stage"):
        progress.advance()


def test_the_end_of_a_run_ends_the_display():
    out = Terminal()
    with pytest.raises(KeyboardInterrupt), ProgressDisplay(out=out, err=io.StringIO()) as progress:
        progress.stage("exploration", total=4)
        raise KeyboardInterrupt
    assert "\x1b[?25h" in out.getvalue()  # the cursor is back


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.2, "0 s"), (59.4, "59 s"), (59.6, "1 min 0 s"), (125, "2 min 5 s"), (7500, "2 h 5 min")],
)
def test_durations(seconds, text):
    assert duration(seconds) == text
