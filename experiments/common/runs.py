"""Runs of a list of cases: one folder each, finished ones skipped, killed ones taken up where they were.

All cases of a seed begin with the same walk, so their first exploration is done once.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from estexp_jax.recovery.cycle import run
from estexp_jax.recovery.state import RunState
from estexp_jax.report.recover_files import record
from estexp_jax.runs import load_checkpoint, open_run, save_checkpoint, versions, write_json
from estexp_jax.runs.fleet import Beat, do
from estexp_jax.runs.lock import hold
from experiments.common.case import Case
from experiments.common.options import Options
from experiments.common.world import job

_CHECKPOINT, _RESULT = "checkpoint.npz", "run.json"
_EVERY = 2.0
"""Least time between two checkpoints, s."""


def run_all(cases: Sequence[Case], options: Options) -> None:
    """Run what is not yet finished.

    Args:
        cases: of one experiment.
        options: of the experiment.

    Raises:
        InputError: another process is at work on the experiment.
    """
    store = options.store
    todo = [case for case in cases if not finished(case, store)]
    first = {(case.seed, case.size, case.robot): case for case in todo}
    held = hold(options.out)
    with options.crew() as crew:
        do("first walks", [(_first, (case, store)) for case in first.values()], crew, _beats(store))
        do("runs", [(_one, (case, store)) for case in todo], crew, _beats(store))
    del held


def each(title: str, calls: Sequence[tuple[Any, ...]], options: Options) -> list[Any]:
    """Call functions with arguments, (function, *arguments) each, by the experiment's workers.

    Returns:
        What they gave, in the order of the calls.
    """
    held = hold(options.out)
    with options.crew() as crew:
        results = do(title, [(function, tuple(rest)) for function, *rest in calls], crew, _beats(options.store))
    del held
    return results


def finished(case: Case, store: Path) -> bool:
    """Whether a case has its result."""
    return (store / case.name / _RESULT).is_file()


def state_of(case: Case, store: Path) -> RunState:
    """The end of a finished run."""
    return RunState.from_tree(load_checkpoint(store / case.name / _CHECKPOINT))


def _first(case: Case, store: Path) -> None:
    """The exploration that all cases of a seed begin with."""
    settings = case.settings.to_json()  # of damage and diagnosis, too, which have no part in it
    config = {name: settings[name] for name in ("seed", "population", "generations", "steps")}
    marker = {"experiment": "first walk", "config": config}
    folder = open_run(_first_folder(case, store), resume=True, marker=marker, patience=math.inf)
    path = folder.file(_CHECKPOINT)
    saved = load_checkpoint(path)
    state = RunState() if saved is None else RunState.from_tree(saved)
    with Beat(_beats(store), folder.path.name) as beat:
        save_checkpoint(path, _advanced(case, state, _saver(path, case, beat), until="damage").to_tree())


def _one(case: Case, store: Path) -> None:
    marker = {"experiment": "recover", "config": case.settings.to_json()}
    folder = open_run(store / case.name, resume=True, marker=marker, patience=math.inf)
    if finished(case, store):
        return  # by another experiment, while we waited for the folder
    path, begin = folder.file(_CHECKPOINT), time.monotonic()
    saved = load_checkpoint(path) or load_checkpoint(_first_folder(case, store) / _CHECKPOINT)
    with Beat(_beats(store), case.name) as beat:
        state = _advanced(case, RunState.from_tree(saved), _saver(path, case, beat))
    save_checkpoint(path, state.to_tree())
    found = record(state, case.settings.axis, job(case).planted, case.settings.to_json())
    cost = {"wall_s": time.monotonic() - begin, "residuals": state.residuals}
    write_json(folder.file(_RESULT), {**case.labels(), **found, **cost, "versions": versions()})


def _advanced(case: Case, state: RunState, save: Callable[[RunState], None], until: str = "done") -> RunState:
    parent = os.getppid()
    if state.phase == until:
        return state
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


def _saver(path: Path, case: Case, beat: Beat) -> Callable[[RunState], None]:
    last = [time.monotonic()]

    def save(state: RunState) -> None:
        if time.monotonic() - last[0] > _EVERY:
            save_checkpoint(path, state.to_tree())
            last[0] = time.monotonic()
        beat.tell(_share(state, case), f"{state.phase} {state.number} of {case.settings.passes}")

    return save


def _share(state: RunState, case: Case) -> float:
    """How much of a run is behind it: phases, and generations of the one under way, which may end sooner."""
    phases = len(state.controllers) + len(state.diagnoses)
    rows = sum((row.phase, row.number) == (state.phase, state.number) for row in state.history)
    return min((phases + min(rows / case.settings.generations, 1.0)) / (2 * case.settings.passes + 1), 1.0)


def _first_folder(case: Case, store: Path) -> Path:
    return store / "first" / f"{case.robot}-{case.seed}"


def _beats(store: Path) -> Path:
    return store / "under_way"
