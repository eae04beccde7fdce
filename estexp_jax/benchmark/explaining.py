"""How long explaining takes, and how much memory: whole commands in processes of their own, beside `mujoco.sysid`.

Both are given the same recordings of a shipped robot with a shipped effect. `mujoco.sysid` fits what a model's joints
and motors have; `explain` also says what the model has no place for, so it answers more.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any, final

from estexp_jax.benchmark.parameter_fit import fit_parameters, sysid_version
from estexp_jax.benchmark.process import peak_mb
from estexp_jax.package_data import model_path
from estexp_jax.runs import ProgressDisplay

_COMMAND = """
import runpy, sys
from estexp_jax.benchmark.process import peak_mb
sys.argv = ["estexp", *sys.argv[1:]]
try:
    runpy.run_module("estexp_jax", run_name="__main__")
finally:
    print(peak_mb())
"""
"""Runs a command, and says at its end how much memory its process took."""


@final
@dataclass(frozen=True)
class ShippedLog:
    """Recordings of a shipped robot with an effect that its model lacks.

    Attributes:
        robot: name of the shipped model.
        effect: what is concealed, as `estexp record --effect` takes it.
        duration: of each of its three recordings, s.
    """

    robot: str
    effect: str
    duration: float = 6.0


LOGS = (ShippedLog("leg", "coulomb_friction@knee T=0.6"), ShippedLog("leg", "command_delay@knee delay=0.03"))


def explaining_times(
    repeats: int, seed: int, progress: ProgressDisplay, logs: Sequence[ShippedLog] = LOGS
) -> list[dict[str, Any]]:
    """Measure; one entry for each log.

    Args:
        repeats: how often each is timed, in turns; medians count.
        seed: of motions and noise.
        progress: shows how far it is.
        logs: what is explained.

    Returns:
        Entries with `robot`, `effect`, `cold_s` (no compiled program on disk) and `wall_s` (with those of the run
        before), both from the command's start to its end, report included; `peak_mb`, `robot_steps`, `verdict`,
        `found`; and `sysid`: `wall_s`, `peak_mb` and version of `mujoco.sysid`, None where it is not installed; with
        `ratio_to_sysid`.
    """
    found = []
    for log in logs:
        progress.stage(f"explaining {log.effect}", 1 + repeats)
        with tempfile.TemporaryDirectory(prefix="estexp-bench-") as folder:
            found.append(_one(log, repeats, seed, progress, Path(folder)))
    return found


def _one(log: ShippedLog, repeats: int, seed: int, progress: ProgressDisplay, folder: Path) -> dict[str, Any]:
    recorded, out, version = folder / "recorded", folder / "out", sysid_version()
    record = ["record", str(model_path(log.robot)), "--effect", log.effect, "--duration", str(log.duration)]
    _run(["-c", _COMMAND, *record, "--out", str(recorded), "--seed", str(seed)], folder)
    manifest = str(recorded / "recordings.toml")
    explain = ["-c", _COMMAND, "explain", manifest, "--out", str(out), "--force"]
    cold, *_ = _run(explain, folder)
    progress.advance(note=f"cold {cold:.0f} s")
    runs, fits = [], []
    for _ in range(repeats):
        runs.append(_run(explain, folder))
        if version is not None:
            fits.append(_run(["-m", "estexp_jax.benchmark.explaining", manifest], folder))
        progress.advance(note=f"{runs[-1][0]:.0f} s")
    findings = json.loads((out / "findings.json").read_text(encoding="utf-8"))
    entry = {"robot": log.robot, "effect": log.effect, "duration_s": log.duration, "cold_s": cold, **_medians(runs)}
    entry |= {"robot_steps": findings["cost"]["robot_steps"], "verdict": findings["verdict"]}
    entry["found"] = [f"{each['effect']}@{each['name']}" for each in findings["what"]]
    sysid = {**_medians(fits), "version": version} if fits else None
    ratio = None if sysid is None else entry["wall_s"] / sysid["wall_s"]
    return {**entry, "sysid": sysid, "ratio_to_sysid": ratio}


def _run(arguments: Sequence[str], folder: Path) -> tuple[float, float]:
    """Wall time, s, and peak memory, MiB, of a Python process; its programs are kept in the folder."""
    environment = {**os.environ, "XDG_CACHE_HOME": str(folder / "cache")}
    environment.pop("JAX_COMPILATION_CACHE_DIR", None)
    begin = time.perf_counter()
    done = subprocess.run([sys.executable, *arguments], env=environment, capture_output=True, text=True)
    took = time.perf_counter() - begin
    if done.returncode:
        raise RuntimeError(f"a measured process ended with {done.returncode}:\n{done.stderr}")
    return took, float(done.stdout.split()[-1])


def _medians(runs: Sequence[tuple[float, float]]) -> dict[str, float]:
    return {"wall_s": median(wall for wall, _ in runs), "peak_mb": median(memory for _, memory in runs)}


if __name__ == "__main__":
    fit_parameters(Path(sys.argv[1]))
    sys.stdout.write(f"{peak_mb()}\n")
