"""Runs of a list of cases: one folder each, finished ones skipped, killed ones taken up where they were.

All cases of a seed begin with the same walk, so their first exploration is done once.
"""

from __future__ import annotations

import multiprocessing
import os
import time
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from estexp_jax.recovery.cycle import run
from estexp_jax.recovery.state import RunState
from estexp_jax.report.recover_files import record
from estexp_jax.runs import load_checkpoint, open_run, save_checkpoint, versions, write_json
from experiments.common.case import Case
from experiments.common.world import job

_CHECKPOINT, _RESULT = "checkpoint.npz", "run.json"
_EVERY = 2.0
"""Least time between two checkpoints, s."""


def run_all(cases: Sequence[Case], store: Path, workers: int) -> None:
    """Run what is not yet finished.

    Args:
        cases: of one experiment.
        store: folder of their folders.
        workers: processes at a time.
    """
    todo = [case for case in cases if not finished(case, store)]
    first = {(case.seed, case.size, case.robot): case for case in todo}
    each("first walks", [(_first, case, store) for case in first.values()], workers)
    each("runs", [(_one, case, store) for case in todo], workers)


def each(title: str, calls: Sequence[tuple[Any, ...]], workers: int) -> list[Any]:
    """Call functions with arguments, (function, *arguments) each, in worker processes; a line for each that is done.

    Returns:
        What they gave, in the order of the calls.
    """
    begin, results = time.monotonic(), [None] * len(calls)

    def done(index: int, count: int, result: Any) -> None:
        results[index] = result
        spent = time.monotonic() - begin
        left = spent / count * (len(calls) - count)
        print(f"{title}: {count} of {len(calls)}, {spent:.0f} s, about {left:.0f} s left", flush=True)

    if workers == 1:
        for index, (function, *arguments) in enumerate(calls):
            done(index, index + 1, function(*arguments))
        return results
    with ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn")) as pool:
        futures = {pool.submit(*call): index for index, call in enumerate(calls)}
        for count, future in enumerate(as_completed(futures), start=1):
            done(futures[future], count, future.result())
    return results


def finished(case: Case, store: Path) -> bool:
    """Whether a case has its result."""
    return (store / case.name / _RESULT).is_file()


def state_of(case: Case, store: Path) -> RunState:
    """The end of a finished run."""
    return RunState.from_tree(load_checkpoint(store / case.name / _CHECKPOINT))


def _first(case: Case, store: Path) -> None:
    """The exploration that all cases of a seed begin with."""
    path = _first_path(case, store)
    if not path.is_file():
        path.parent.mkdir(parents=True, exist_ok=True)
        save_checkpoint(path, _advanced(case, RunState(), lambda state: None, until="damage").to_tree())


def _one(case: Case, store: Path) -> None:
    marker = {"experiment": "recover", "config": case.settings.to_json()}
    folder = open_run(store / case.name, resume=True, marker=marker)
    path, begin = folder.file(_CHECKPOINT), time.monotonic()
    saved = load_checkpoint(path) or load_checkpoint(_first_path(case, store))
    state = _advanced(case, RunState.from_tree(saved), _saver(path))
    save_checkpoint(path, state.to_tree())
    found = record(state, case.settings.axis, job(case).planted, case.settings.to_json())
    cost = {"wall_s": time.monotonic() - begin, "residuals": state.residuals}
    write_json(folder.file(_RESULT), {**case.labels(), **found, **cost, "versions": versions()})


def _advanced(case: Case, state: RunState, save: Callable[[RunState], None], until: str = "done") -> RunState:
    parent = os.getppid()
    for reached in _until(run(job(case), state), until):
        state = reached
        save(state)
        if os.getppid() != parent:
            raise SystemExit("the experiment that this worker belongs to is gone")
    return state


def _until(states: Iterable[RunState], phase: str) -> Iterable[RunState]:
    for state in states:
        yield state
        if state.phase == phase:
            return


def _saver(path: Path) -> Callable[[RunState], None]:
    last = [time.monotonic()]

    def save(state: RunState) -> None:
        if time.monotonic() - last[0] > _EVERY:
            save_checkpoint(path, state.to_tree())
            last[0] = time.monotonic()

    return save


def _first_path(case: Case, store: Path) -> Path:
    return store / "first" / f"{case.robot}-{case.seed}.npz"
