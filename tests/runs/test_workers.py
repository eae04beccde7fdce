"""Workers: other processes that end with this one, and errors that reach the caller."""

import operator
import os
import subprocess
import sys
from pathlib import Path

import pytest

import estexp_jax
from estexp_jax.errors import InputError
from estexp_jax.runs.workers import ProcessPool, SerialPool, worker_pool_of

CALLS = [(operator.mul, (i, i)) for i in range(5)]


def test_what_a_call_raises_comes_out():
    with worker_pool_of(2) as pool, pytest.raises(ZeroDivisionError):
        list(pool.each([(operator.truediv, (1, 0)), *CALLS]))
    assert type(worker_pool_of(1)) is SerialPool and type(worker_pool_of(3)) is ProcessPool


def test_workers_are_other_processes_and_one_alone_is_this():
    with worker_pool_of(2) as pool:
        assert os.getpid() not in dict(pool.each([(os.getpid, ())] * 3)).values()
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
    with worker_pool_of(2) as pool, pytest.raises(InputError, match="a.xml: is wrong; b"):
        list(pool.each([(_wrong, ())]))


def _wrong():
    raise InputError("is wrong", where="a.xml", right="b")
