"""Versions and machine of a run, for its results."""

from __future__ import annotations

import os
import platform
from importlib import metadata
from pathlib import Path

_PACKAGES = ("estexp_jax", "mujoco", "mujoco-mjx", "jax", "jaxlib", "numpy")


def versions() -> dict[str, str]:
    """Versions of Python, this package and its numerical packages, and the machine: `platform`, `cpu`, `cores`."""
    machine = {"platform": platform.platform(), "cpu": _cpu(), "cores": str(os.cpu_count() or 1)}
    return {"python": platform.python_version(), **{name: version(name) for name in _PACKAGES}, **machine}


def version(package: str) -> str:
    """The version of an installed package, or `not installed`, as for this package in a bare checkout."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "not installed"


def _cpu() -> str:
    """The processor's name, which `platform` does not report on Linux."""
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()
