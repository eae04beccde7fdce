"""Workers on the machines of a Ray cluster; imported only if Ray is requested.

Ray restarts a task elsewhere if its worker or machine is lost; the task has to resume from its own checkpoint.
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
from estexp_jax.runs.worker_pool import Call, WorkerPool

LOCAL, AUTO = "local", "auto"
"""A private Ray of this command; the cluster that runs on this machine."""

_RETRIES = 20
"""Restarts of a run whose workers are lost; if it fails more often, the run itself kills them."""
_MAX_SUBMITTED = 1000
"""Limit of tasks submitted to Ray at a time, since a sweep may have any number; enough for any cluster."""
_STORE_BYTES = 100_000_000
"""Size of a local Ray's object store; results are small, and Ray's default is a third of the memory."""
_PATIENCE = 10.0
"""Time limit for an address to answer, s."""


@final
class RayPool(WorkerPool):
    """The machines of a Ray cluster: one processor a call, and a GPU where they have some that JAX can use.

    Args:
        address: of a cluster, `host:port` as printed by `ray start --head`, or `auto`; `local`: a private Ray.
        workers: calls at a time; None: as many as there are processors (or GPUs).
        paths: folders with the modules of the calls, on every machine.

    Raises:
        InputError: Ray is not installed, or the address does not answer.
    """

    def __init__(self, address: str, workers: int | None, paths: Sequence[str]) -> None:
        check_installed()
        _check_answers(address)
        self._ray = _imported(address)
        self._max_running = workers or _MAX_SUBMITTED
        _connect(self._ray, address, workers, paths)
        self._task = self._ray.remote(_call).options(
            num_cpus=1,
            num_gpus=self._gpus(),  # with one, Ray ends the worker after each call, since JAX never releases a GPU
            max_retries=_RETRIES,
            scheduling_strategy="SPREAD",
        )

    def each(self, calls: Sequence[Call]) -> Iterator[tuple[int, Any]]:
        """Run all calls; those whose worker is lost are restarted."""
        waiting, running = iter(enumerate(calls)), {}
        while True:
            for index, (function, arguments) in islice(waiting, self._max_running - len(running)):
                running[self._task.remote(function, arguments)] = index
            if not running:
                return
            for finished in self._ray.wait(list(running), num_returns=1)[0]:
                yield running.pop(finished), self._result(finished)

    def summary(self) -> str:
        """In words, with the machines that are alive now."""
        machines = [node["Resources"] for node in self._ray.nodes() if node["Alive"]]
        parts = [f"{len(machines)} machine{'s' if len(machines) != 1 else ''}"]
        for kind, unit in (("CPU", "processors"), ("GPU", "GPUs")):
            number = sum(resources.get(kind, 0.0) for resources in machines)
            parts += [f"{number:g} {unit}"] if number or kind == "CPU" else []
        return f"Ray on {', '.join(parts)}"

    def __exit__(self, *_: object) -> None:
        self._ray.shutdown()

    def _gpus(self) -> int:
        """GPUs per call: none if the cluster has none, or if JAX is installed without GPU support."""
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
    """GPUs per call, given the JAX platform on which a worker with a GPU computes."""
    return 0 if platform == "cpu" else 1


def _call(function: Any, arguments: tuple[Any, ...]) -> Any:
    return function(*arguments)


def _platform() -> str:
    import jax

    return jax.default_backend()


def check_installed() -> None:
    """Check that Ray can be imported.

    Raises:
        InputError: it is not installed; names the command that installs it.
    """
    if find_spec("ray") is None:
        right = "pip install 'estexp_jax[cluster]', on every machine; or --workers N, processes on this one"
        raise InputError("Ray is not installed", where="--ray", right=right)


def _imported(address: str) -> Any:
    """Import Ray, after setting the environment variables that it reads on import."""
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")  # no usage statistics
    chosen = "ray" in sys.modules or any(name.startswith("RAY_AUTH_") for name in os.environ)
    if address == LOCAL and not chosen:
        # Only our own processes may submit work; by default, Ray would keep a token in the home folder. If Ray is
        # already imported, the mode is fixed: its servers would ask for a token that its client does not send.
        os.environ |= {"RAY_AUTH_MODE": "token", "RAY_AUTH_TOKEN": secrets.token_hex(32)}
    import ray  # pyright: ignore[reportMissingImports]

    return ray


def _connect(ray: Any, address: str, workers: int | None, paths: Sequence[str]) -> None:
    search_path = [path for path in (*paths, os.environ.get("PYTHONPATH", "")) if path]
    environment = {"PYTHONPATH": os.pathsep.join(dict.fromkeys(search_path)), "TF_CPP_MIN_LOG_LEVEL": "3"}
    common = {"runtime_env": {"env_vars": environment}, "log_to_driver": False, "logging_level": "error"}
    if address == LOCAL:
        own = {"num_cpus": workers, "object_store_memory": _STORE_BYTES, "include_dashboard": False}
        ray.init(address=LOCAL, **own, **common)
        return
    try:
        ray.init(address=address, **common)
    except (ConnectionError, RuntimeError, ValueError, ray.exceptions.RayError) as error:
        what = f"{str(error).strip().partition(chr(10))[0]} (if it asks for a token: RAY_AUTH_MODE=token)"
        raise _unreachable(address, what) from None


def _check_answers(address: str) -> None:
    """Check that the address answers, since Ray itself would try for a minute and log."""
    if address in (LOCAL, AUTO):
        return
    host, _, port = address.rpartition(":")
    if not host or not port.isdecimal():
        raise _unreachable(address, "is no address")
    try:
        socket.create_connection((host, int(port)), _PATIENCE).close()
    except (OSError, OverflowError) as error:
        raise _unreachable(address, f"nobody answers: {error}") from None


def _unreachable(address: str, what: str) -> InputError:
    right = "host:port as `ray start --head` prints it, auto for this machine's cluster, or nothing for a private Ray"
    return InputError(what, where=f"--ray {address}", right=right)
