"""The processor that programs are compiled for."""

import hashlib
import platform
from functools import cache
from pathlib import Path


@cache
def processor_name() -> str:
    """A name for the features of this machine's processor: programs compiled for one may not run on another."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    features = [line for line in lines if line.startswith(("model name", "flags", "Features", "CPU part"))]
    text = "\n".join([platform.machine(), platform.processor(), *dict.fromkeys(features)])
    return f"{platform.machine()}-{hashlib.sha256(text.encode()).hexdigest()[:12]}"
