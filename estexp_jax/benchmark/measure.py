"""This machine's simulation speed, every engine on the same robots, side by side.

Engines are timed in turns (A B C A B C ...) and medians are compared, so that what else the machine does meets all of
them alike. None is timed before its physics has been compared with the converged C engine's.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from time import perf_counter, process_time
from typing import Any, final

import numpy as np

from estexp_jax.benchmark.engines import (
    C_ENGINES,
    JAX_ENGINES,
    TITLES,
    Made,
    Runner,
    agreement_json,
    runner,
)
from estexp_jax.benchmark.estimation import estimation_time
from estexp_jax.benchmark.explaining import explaining_times
from estexp_jax.benchmark.process import alone
from estexp_jax.benchmark.subject import BenchmarkRobots, BenchmarkTask, load
from estexp_jax.benchmark.sweep import sweep
from estexp_jax.errors import InputError
from estexp_jax.physics.engines.batching import cores
from estexp_jax.physics.engines.devices import accelerated, device
from estexp_jax.runs import ProgressDisplay, enable_compilation_cache, versions

_CONTROL_STEP = 0.01
"""s, as shipped."""
_MATRIX = 1536


@final
@dataclass(frozen=True)
class BenchConfig:
    """What is measured; the command's options have the valid ranges.

    Attributes:
        model, feet, population, steps, seed: as in `BenchmarkTask`.
        substeps: physics steps a control step, of one race each; empty: as shipped, and 1.
        repeats: how often each engine is timed.
        sweep: whether to go through populations from 1 to 6400.
        estimation: whether to time a generation of the estimation phase.
        explain: whether to time explaining shipped logs.
    """

    model: str | None = None
    feet: bool = False
    population: int = 200
    steps: int = 1000
    substeps: tuple[int, ...] = ()
    repeats: int = 5
    sweep: bool = False
    estimation: bool = True
    explain: bool = False
    seed: int = 0

    def races(self) -> list[BenchmarkTask]:
        """One for each number of physics steps.

        Raises:
            InputError: the model cannot be used.
        """
        step = load(self.model, feet=self.feet).model.opt.timestep
        shipped = max(1, round(_CONTROL_STEP / step))
        race = BenchmarkTask(self.model, self.feet, self.population, self.steps, shipped, self.seed)
        return [replace(race, substeps=n) for n in dict.fromkeys(self.substeps or (shipped, 1))]


def quick_bench(config: BenchConfig) -> BenchConfig:
    """Small and short: shows that everything works, and measures little."""
    return replace(config, population=min(config.population, 48), steps=min(config.steps, 100), repeats=2)


def measure(config: BenchConfig, progress: ProgressDisplay, made: Made = runner) -> dict[str, Any]:
    """Measure.

    Args:
        config: what.
        progress: shows how far it is.
        made: gives an engine by name; raises InputError where it cannot simulate the robot.

    Returns:
        The contents of `bench.json`.

    Raises:
        InputError: the model cannot be used.
    """
    enable_compilation_cache()
    load_before = os.getloadavg()[0] if hasattr(os, "getloadavg") else None
    first, *others = races = config.races()
    main = _race(first, config.repeats, progress, made)
    for entry in main["engines"]:
        if not entry["refused"]:
            progress.stage(f"{entry['name']} in processes of its own")
            entry.update(alone(entry["name"], first))
    result = {"model": _model_name(config), "population": config.population, "steps": config.steps, **main}
    result["also"] = [_race(race, config.repeats, progress, made) for race in others]
    trusted = [e["name"] for e in main["engines"] if not e["refused"]]
    if config.estimation and "lanes" in trusted:
        progress.stage("an estimation generation")
        result["estimation"] = estimation_time(races[0], config.repeats)
    if config.sweep:
        result["sweep"] = sweep(races[0], trusted, progress, made)
    if config.explain:
        result["explain"] = explaining_times(config.repeats, config.seed, progress)
    machine = {"cores": cores(), "device": device(), "load_average_before": load_before}
    conditions = {"repeats": config.repeats, **machine, "seed": config.seed}
    return {**result, **conditions, "notes": _notes(), "versions": versions()}


def _race(race: BenchmarkTask, repeats: int, progress: ProgressDisplay, made: Made) -> dict[str, Any]:
    """Check all engines, time those that agree; the entries of `engines`."""
    field, title = BenchmarkRobots(race), f"{race.substeps} physics step(s) a control step"
    entries, runners = [], []
    for name in (*C_ENGINES, *JAX_ENGINES):
        progress.stage(f"{title}: checking {name}")
        entry, candidate = _checked(name, field, made)
        entries.append(entry)
        if candidate is not None:
            runners.append(candidate)
    progress.stage(f"{title}: timing", repeats * len(runners))
    rates, busy, peak = timed(runners, race.substeps, repeats, progress)
    _compare(entries, runners, rates, peak)
    for entry in entries:
        entry["robot_steps_per_cpu_s"] = float(np.median(busy[entry["name"]])) if entry["name"] in busy else None
    times = {"physics_step_s": field.robot.model.opt.timestep, "substeps": race.substeps}
    return {**times, "arithmetic_peak_flops": peak, "engines": entries}


def _checked(name: str, field: BenchmarkRobots, made: Made) -> tuple[dict[str, Any], Runner | None]:
    """An engine's entry, and the engine unless it is refused."""
    blank = dict.fromkeys(
        ("robot_steps_per_s", "ratio_to_serial", "ratio_to_c_all_cores", "compile_s", "first_result_s", "peak_mb")
    )
    entry: dict[str, Any] = {"name": name, "title": TITLES.get(name, name), **blank, "agreement": None, "refused": None}
    try:
        candidate = made(name, field)
    except InputError as error:
        return {**entry, "refused": str(error)}, None
    found = candidate.agreement()
    entry["agreement"] = agreement_json(found)
    if not found.agrees:
        return {**entry, "refused": f"it {found.sentence()}"}, None
    return entry, candidate


def timed(
    runners: Sequence[Runner], substeps: int, repeats: int, progress: ProgressDisplay
) -> tuple[dict[str, list[float]], dict[str, list[float]], float]:
    """Robot steps of each engine, one number a repeat, per second and per second of processor time (of all threads).

    The third is the arithmetic peak, flops per second.
    """
    for each in runners:
        each.simulate(each.robots, min(2, each.steps))
    rates: dict[str, list[float]] = {each.name: [] for each in runners}
    busy: dict[str, list[float]] = {each.name: [] for each in runners}
    peaks = []
    for _ in range(repeats):
        for each in runners:
            begin, used, robot_steps = perf_counter(), process_time(), each.robots * each.steps * substeps
            each.simulate(each.robots, each.steps)
            rates[each.name].append(robot_steps / (perf_counter() - begin))
            busy[each.name].append(robot_steps / max(process_time() - used, 1e-9))
            progress.advance(note=f"{each.name} {rates[each.name][-1]:,.0f} steps/s")
        peaks.append(_arithmetic())
    return rates, busy, max(peaks)


def _compare(entries: list[dict[str, Any]], runners: Sequence[Runner], rates: Any, peak: float) -> None:
    medians = {name: float(np.median(each)) for name, each in rates.items()}
    serial = medians.get("serial", np.nan)
    threads = max((medians[name] for name in ("rollout", "batch") if name in medians), default=np.nan)
    by_name = {each.name: each for each in runners}
    for entry in entries:
        each = by_name.get(entry["name"])
        if each is None:
            continue
        rate = medians[each.name]
        entry.update(robot_steps_per_s=rate, ratio_to_serial=rate / serial, ratio_to_c_all_cores=rate / threads)
        entry.update(rates=rates[each.name], robots=each.robots, steps=each.steps, **each.facts())
        work = entry.get("flops_per_robot_step")
        entry["percent_of_peak"] = None if work is None or accelerated() else 100.0 * rate * work / peak


def _arithmetic() -> float:
    """Flops per second of a float32 matrix product in numpy on all its threads: what arithmetic can reach here."""
    matrix = np.ones((_MATRIX, _MATRIX), np.float32)
    begin = perf_counter()
    np.dot(matrix, matrix)
    return 2.0 * _MATRIX**3 / (perf_counter() - begin)


def _model_name(config: BenchConfig) -> str:
    return config.model or ("quadruped, feet only" if config.feet else "quadruped")


def _notes() -> list[str]:
    return [
        "; ".join(f"{name}: {title}" for name, title in TITLES.items()) + ".",
        "Medians of interleaved measurements; a robot step is one physics step of one robot.",
        "The C engine runs the nominal model and keeps no readings, which favours it; in MJX and lanes every robot has "
        "masses, gains, damping and gravity of its own, and all readings, commands and positions come back.",
        "serial walks fewer robots and mjx fewer steps than the rest (fields robots, steps of each engine).",
        "robot_steps_per_cpu_s counts the processor time of all threads: on a machine busy with other work it "
        "says more than robot_steps_per_s.",
        "ratio_to_c_all_cores is to the faster of rollout and batch.",
        "flops_per_robot_step is a lower bound (XLA's count, each loop once: one Newton step); percent_of_peak is of "
        "the best float32 matrix product of numpy on all cores in the same run.",
        "compile_s and first_result_s are measured in fresh processes, from the first call to the first result, "
        "imports not included; peak_mb is the process's largest resident memory, the imports' included.",
    ]
