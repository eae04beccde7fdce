"""One engine in a process of its own: how long until its first result, and how much memory it takes.

Run as `python -m estexp_jax.benchmark.process` with a JSON object as argument; answers with one on its last line.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from estexp_jax.benchmark.subject import BenchmarkTask

_ROOT = Path(__file__).resolve().parents[2]


def alone(name: str, race: BenchmarkTask) -> dict[str, Any]:
    """An engine in fresh processes: for JAX first without any compiled program on disk, then with them.

    Returns:
        `compile_s`: from the first call to the first result, with nothing compiled before; tracing and lowering
        included. `first_result_s`: the same where the programs lie in the cache on disk. `import_s`: importing Python's
        modules, in neither. `xla_s`: XLA's share of `compile_s`. `peak_mb`: the process's largest resident memory in a
        whole walk. `rise_mb`: by how much that is more than after the imports.
    """
    with tempfile.TemporaryDirectory(prefix="estexp-bench-") as cache:
        if name not in ("mjx", "lanes"):
            found = _ask(name, race, "")
            return {"compile_s": 0.0, **{k: v for k, v in found.items() if k != "xla_s"}}
        cold = _ask(name, race, cache)
        warm = _ask(name, race, cache)
    return {"compile_s": cold["first_result_s"], "xla_s": cold["xla_s"], **{k: warm[k] for k in warm if k != "xla_s"}}


def _ask(name: str, race: BenchmarkTask, cache: str) -> dict[str, Any]:
    question = json.dumps({"engine": name, "race": asdict(race), "cache": cache})
    paths = [str(_ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths), "JAX_COMPILATION_CACHE_DIR": cache}
    command = [sys.executable, "-m", "estexp_jax.benchmark.process", question]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"the process of engine '{name}' ended with {done.returncode}:\n{done.stderr}")
    return json.loads(done.stdout.splitlines()[-1])


def _answer(question: dict[str, Any]) -> dict[str, float]:
    begin = time.perf_counter()
    from estexp_jax.benchmark.engines import runner
    from estexp_jax.benchmark.subject import BenchmarkRobots, BenchmarkTask
    from estexp_jax.runs import count_compilations

    if question["cache"]:
        import jax

        jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
        jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)
    imported, before = time.perf_counter(), peak_mb()
    field = BenchmarkRobots(BenchmarkTask(**question["race"]))
    if question["engine"] in ("serial_open", "rollout"):
        field.recorded.sum()  # no part of the engine
    start = time.perf_counter()
    with count_compilations() as compilations:
        engine = runner(question["engine"], field)
        engine.simulate(engine.robots, 1)
    first = time.perf_counter()
    engine.simulate(engine.robots, engine.steps)
    peak = peak_mb()
    return {
        "import_s": imported - begin,
        "first_result_s": first - start,
        "xla_s": compilations.seconds,
        "peak_mb": peak,
        "rise_mb": peak - before,
    }


def peak_mb() -> float:
    """Largest resident memory of this process so far, MiB."""
    try:  # not ru_maxrss on Linux: a process starts with that of the one that started it
        for line in Path("/proc/self/status").read_text(encoding="ascii").splitlines():
            if line.startswith("VmHWM"):
                return int(line.split()[1]) / 1024
    except OSError:
        pass
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (2**20 if sys.platform == "darwin" else 2**10)


if __name__ == "__main__":
    sys.stdout.write(json.dumps(_answer(json.loads(sys.argv[1]))) + "\n")
