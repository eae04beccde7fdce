"""Many runs in one view: results in order, and the progress of all of them."""

import io
import json
import operator
import os
import socket
import time

import pytest

from estexp_jax.runs import ProgressDisplay
from estexp_jax.runs.fleet import Heartbeat, run_all, under_way
from estexp_jax.runs.workers import SerialPool, worker_pool_of

CALLS = [(operator.mul, (i, i)) for i in range(5)]


@pytest.mark.parametrize("workers", [None, 2])
def test_results_come_in_the_order_of_the_calls(workers, tmp_path):
    with worker_pool_of(workers) as pool:
        assert run_all("squares", CALLS, pool, tmp_path) == [0, 1, 4, 9, 16]


def _report_slowly(folder, name, shares):
    with Heartbeat(folder, name) as heartbeat:
        for share in shares:
            heartbeat.report(share, f"part {share:g}")
            time.sleep(2.1)


def test_the_view_counts_what_is_under_way(tmp_path, monkeypatch):
    monkeypatch.setattr("estexp_jax.runs.fleet._EVERY", 0.1)  # many looks while a run sleeps
    out, err = io.StringIO(), io.StringIO()
    calls = [(_report_slowly, (tmp_path, "b", (0.5,))), (_report_slowly, (tmp_path, "c", ()))]
    with Heartbeat(tmp_path, "a") as other:
        other.report(0.25, "elsewhere")
        run_all("runs", calls, SerialPool(), tmp_path, ProgressDisplay(out=out, err=err, period=0.1))
        assert set(under_way(tmp_path)) == {"a"}
    assert under_way(tmp_path) == {}
    assert "runs: 2 to do, this process" in out.getvalue() and "runs: 2 done in" in out.getvalue()
    assert "runs: 0.8/2" in err.getvalue()
    assert f"2 under way (a on {socket.gethostname()}: elsewhere; b on" in err.getvalue()


def test_a_run_that_has_long_said_nothing_is_not_shown(tmp_path):
    (tmp_path / "lost.json").write_text(json.dumps({"share": 0.5, "where": "x", "machine": "y"}))
    (tmp_path / "half.json").write_text("{")
    assert set(under_way(tmp_path)) == {"lost"}
    os.utime(tmp_path / "lost.json", (0, 0))
    assert under_way(tmp_path) == {}
