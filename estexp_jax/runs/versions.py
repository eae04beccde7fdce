"""What a run ran on, for its results: versions and machine."""

from __future__ import annotations

import os
import platform
from importlib import metadata
from pathlib import Path

_PACKAGES = ("estexp_jax", "mujoco", "mujoco-mjx", "jax", "jaxlib", "numpy")


def versions() -> dict[str, str]:
    """Versions of Python, of this package and of those that compute, and the machine: `platform`, `cpu`, `cores`."""
    machine = {"platform": platform.platform(), "cpu": _cpu(), "cores": str(os.cpu_count() or 1)}
    return {"python": platform.python_version(), **{name: version(name) for name in _PACKAGES}, **machine}


def version(package: str) -> str:
    """The version of an installed package; `not installed` where it is not, as this one in a bare checkout."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "not installed"


def _cpu() -> str:
    """The processor's name; `platform` does not know it on Linux."""
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()
