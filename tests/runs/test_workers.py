"""Many calls at a time give what one after the other gives, and show how far all of them are."""

import io
import json
import operator
import os
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

import estexp_jax
from estexp_jax.errors import InputError
from estexp_jax.runs import ProgressDisplay
from estexp_jax.runs.cluster import gpus_for
from estexp_jax.runs.fleet import Heartbeat, run_all, under_way
from estexp_jax.runs.workers import ProcessPool, SerialPool, worker_pool_of

CALLS = [(operator.mul, (i, i)) for i in range(5)]


@pytest.mark.parametrize("workers", [None, 2])
def test_results_come_in_the_order_of_the_calls(workers, tmp_path):
    with worker_pool_of(workers) as crew:
        assert run_all("squares", CALLS, crew, tmp_path) == [0, 1, 4, 9, 16]


def test_what_a_call_raises_comes_out():
    with worker_pool_of(2) as crew, pytest.raises(ZeroDivisionError):
        list(crew.each([(operator.truediv, (1, 0)), *CALLS]))
    assert type(worker_pool_of(1)) is SerialPool and type(worker_pool_of(3)) is ProcessPool


def test_workers_are_other_processes_and_one_alone_is_this():
    with worker_pool_of(2) as crew:
        assert os.getpid() not in dict(crew.each([(os.getpid, ())] * 3)).values()
    assert dict(SerialPool().each([(os.getpid, ())])) == {0: os.getpid()}


def test_workers_end_with_the_process_that_began_them_when_that_is_killed():
    """Seen: workers of a killed experiment went on with its cases, into a folder that another one had begun."""
    calls = "[(time.sleep, (60,)), (os.write, (1, b'begun\\n')), (time.sleep, (60,))]"
    code = f"import os, time; from estexp_jax.runs.workers import ProcessPool; list(ProcessPool(2).each({calls}))"
    here = Path(estexp_jax.__file__).parents[1]
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, cwd=here) as process:
        assert process.stdout is not None and process.stdout.readline() == b"begun\n"
        process.kill()
        process.communicate(timeout=30)  # the end of what all of them may write to


def test_a_message_for_the_user_survives_the_way_from_a_worker():
    with worker_pool_of(2) as crew, pytest.raises(InputError, match="a.xml: is wrong; b"):
        list(crew.each([(_wrong, ())]))


def _wrong():
    raise InputError("is wrong", where="a.xml", right="b")


def _slow(folder, name, shares):
    with Heartbeat(folder, name) as beat:
        for share in shares:
            beat.tell(share, f"part {share:g}")
            time.sleep(2.1)


def test_the_view_counts_what_is_under_way(tmp_path, monkeypatch):
    monkeypatch.setattr("estexp_jax.runs.fleet._EVERY", 0.1)  # many looks while a run sleeps
    out, err = io.StringIO(), io.StringIO()
    calls = [(_slow, (tmp_path, "b", (0.5,))), (_slow, (tmp_path, "c", ()))]
    with Heartbeat(tmp_path, "a") as other:
        other.tell(0.25, "elsewhere")
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


def test_without_ray_the_command_that_installs_it_is_told(monkeypatch):
    monkeypatch.setattr("estexp_jax.runs.cluster.find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"--ray: Ray is not installed; pip install 'estexp_jax\[cluster\]'"):
        worker_pool_of(ray="local")


@pytest.fixture
def installed(monkeypatch):
    """Ray seems to be there; addresses are judged before it is imported."""
    monkeypatch.setattr("estexp_jax.runs.cluster.find_spec", lambda name: name)


@pytest.mark.parametrize("address", ["nowhere", "127.0.0.1:x", "127.0.0.1:99999", "ray://a"])
def test_a_wrong_address_is_told(address, installed):
    with pytest.raises(InputError, match=f"--ray {address}: .*ray start --head"):
        worker_pool_of(ray=address)


def test_an_address_where_nobody_answers_is_told_soon(installed):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with pytest.raises(InputError, match="nobody answers"):
        worker_pool_of(ray=f"127.0.0.1:{port}")


def test_a_gpu_is_asked_for_where_jax_would_use_it():
    assert [gpus_for(platform) for platform in ("cpu", "gpu", "tpu")] == [0, 1, 1]
