"""Workers on the machines of a Ray cluster; imported only where it is asked for.

A task whose worker or machine is lost is begun again elsewhere by Ray; what it does has to go on from its checkpoint.
https://docs.ray.io/en/latest/ray-core/fault_tolerance/tasks.html
"""

from __future__ import annotations

import os
import secrets
import socket
import sys
from collections.abc import Iterator, Sequence
from importlib.util import find_spec
from itertools import islice
from typing import Any, final

from estexp_jax.errors import InputError
from estexp_jax.runs.workers import Call, WorkerPool

LOCAL, AUTO = "local", "auto"
"""A Ray of this command's own; the cluster that was started on this machine."""

_RETRIES = 20
"""How often a run is begun again whose workers are lost; more, and it is the run that kills them."""
_SUBMITTED = 1000
"""Tasks that wait at Ray at a time: enough for any cluster, and a sweep may have any number."""
_STORE_BYTES = 100_000_000
"""Of a local Ray's object store; results here are small, and Ray would take a third of the memory."""
_PATIENCE = 10.0
"""How long an address may take to answer, s."""


@final
class RayPool(WorkerPool):
    """The machines of a Ray cluster: one processor a call, and a GPU where they have some that JAX can use.

    Args:
        address: of a cluster, `host:port` as `ray start --head` tells it, or `auto`; `local`: a Ray of our own.
        workers: calls at a time; None: as many as there are processors (or GPUs).
        paths: where workers find the modules of the calls, on every machine.

    Raises:
        InputError: Ray is not installed, or nobody answers at the address.
    """

    def __init__(self, address: str, workers: int | None, paths: Sequence[str]) -> None:
        check_installed()
        _check_answers(address)
        self._ray = _imported(address)
        self._most = workers or _SUBMITTED
        _connect(self._ray, address, workers, paths)
        self._task = self._ray.remote(_called).options(
            num_cpus=1,
            num_gpus=self._gpus(),  # where it is one, Ray ends the worker after each call: JAX never gives a GPU back
            max_retries=_RETRIES,
            scheduling_strategy="SPREAD",
        )

    def each(self, calls: Sequence[Call]) -> Iterator[tuple[int, Any]]:
        """Do all calls; those whose worker is lost are begun again."""
        waiting, running = iter(enumerate(calls)), {}
        while True:
            for index, (function, arguments) in islice(waiting, self._most - len(running)):
                running[self._task.remote(function, arguments)] = index
            if not running:
                return
            for done in self._ray.wait(list(running), num_returns=1)[0]:
                yield running.pop(done), self._result(done)

    def about(self) -> str:
        """In words, as it is now."""
        machines = [node["Resources"] for node in self._ray.nodes() if node["Alive"]]
        told = [f"{len(machines)} machine{'s' if len(machines) != 1 else ''}"]
        for kind, unit in (("CPU", "processors"), ("GPU", "GPUs")):
            number = sum(resources.get(kind, 0.0) for resources in machines)
            told += [f"{number:g} {unit}"] if number or kind == "CPU" else []
        return f"Ray on {', '.join(told)}"

    def __exit__(self, *_: object) -> None:
        self._ray.shutdown()

    def _gpus(self) -> int:
        """How many a call asks for: none where there are none, or where JAX is installed without them."""
        if not self._ray.cluster_resources().get("GPU", 0):
            return 0
        platform = self._ray.remote(_platform).options(num_cpus=1, num_gpus=1, max_retries=_RETRIES)
        return gpus_for(self._ray.get(platform.remote()))

    def _result(self, done: Any) -> Any:
        try:
            return self._ray.get(done)
        except self._ray.exceptions.RayTaskError as error:
            if isinstance(error.cause, InputError):
                raise error.cause from None
            raise


def gpus_for(platform: str) -> int:
    """How many GPUs a call asks for, where a worker that was given one computes on `platform` (JAX's word)."""
    return 0 if platform == "cpu" else 1


def _called(function: Any, arguments: tuple[Any, ...]) -> Any:
    return function(*arguments)


def _platform() -> str:
    import jax

    return jax.default_backend()


def check_installed() -> None:
    """Whether there is a Ray to import.

    Raises:
        InputError: there is none; names the command that installs it.
    """
    if find_spec("ray") is None:
        right = "pip install 'estexp_jax[cluster]', on every machine; or --workers N, processes on this one"
        raise InputError("Ray is not installed", where="--ray", right=right)


def _imported(address: str) -> Any:
    """Ray, after what it reads from the environment is there."""
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")  # Ray would report to its makers
    chosen = "ray" in sys.modules or any(name.startswith("RAY_AUTH_") for name in os.environ)
    if address == LOCAL and not chosen:
        # Only what we start may give it work; left to itself, Ray would keep a token in the home folder. Where it is
        # imported already it has made up its mind: its servers would ask for a token that it does not give.
        os.environ |= {"RAY_AUTH_MODE": "token", "RAY_AUTH_TOKEN": secrets.token_hex(32)}
    import ray  # pyright: ignore[reportMissingImports]

    return ray


def _connect(ray: Any, address: str, workers: int | None, paths: Sequence[str]) -> None:
    seen = [path for path in (*paths, os.environ.get("PYTHONPATH", "")) if path]
    environment = {"PYTHONPATH": os.pathsep.join(dict.fromkeys(seen)), "TF_CPP_MIN_LOG_LEVEL": "3"}
    common = {"runtime_env": {"env_vars": environment}, "log_to_driver": False, "logging_level": "error"}
    if address == LOCAL:
        own = {"num_cpus": workers, "object_store_memory": _STORE_BYTES, "include_dashboard": False}
        ray.init(address=LOCAL, **own, **common)
        return
    try:
        ray.init(address=address, **common)
    except (ConnectionError, RuntimeError, ValueError, ray.exceptions.RayError) as error:
        what = f"{str(error).strip().partition(chr(10))[0]} (if it asks for a token: RAY_AUTH_MODE=token)"
        raise _nobody(address, what) from None


def _check_answers(address: str) -> None:
    """Whether somebody listens there: Ray itself would try for a minute, and log."""
    if address in (LOCAL, AUTO):
        return
    host, _, port = address.rpartition(":")
    if not host or not port.isdecimal():
        raise _nobody(address, "is no address")
    try:
        socket.create_connection((host, int(port)), _PATIENCE).close()
    except (OSError, OverflowError) as error:
        raise _nobody(address, f"nobody answers: {error}") from None


def _nobody(address: str, what: str) -> InputError:
    right = "host:port as `ray start --head` tells it, auto for this machine's cluster, or nothing for a Ray of its own"
    return InputError(what, where=f"--ray {address}", right=right)
