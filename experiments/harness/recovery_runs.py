"""Runs of a list of cases: one folder each, finished ones skipped, killed ones taken up where they were.

All cases of a seed begin with the same walk, so their first exploration is done once.
"""

from __future__ import annotations

import json
import math
import os
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from estexp_jax.recovery.cycle import run_cycle
from estexp_jax.recovery.state import RunState
from estexp_jax.report.recover.run_data import run_record
from estexp_jax.runs import load_checkpoint, open_run, save_checkpoint, versions, write_json
from estexp_jax.runs.files import remove_drafts
from estexp_jax.runs.fleet import Heartbeat, run_all
from estexp_jax.runs.lock import lock_folder
from experiments.harness.options import Options
from experiments.harness.oracle import with_true_damage
from experiments.harness.recovery_case import RecoveryCase
from experiments.harness.world import job

_CHECKPOINT, _RESULT = "checkpoint.npz", "run.json"
_EVERY = 2.0
"""Least time between two checkpoints, s."""


def run_cases(cases: Sequence[RecoveryCase], options: Options) -> None:
    """Run what is not yet finished.

    Args:
        cases: of one experiment.
        options: of the experiment.

    Raises:
        InputError: another process is at work on the experiment.
    """
    store = options.store
    todo = [case for case in cases if not finished(case, store)]
    first = {first_folder(case, store): case for case in todo}
    with _alone(options), options.crew() as crew:
        run_all("first walks", [(_first, (case, store)) for case in first.values()], crew, _beats(store))
        run_all("runs", [(_one, (case, store)) for case in todo], crew, _beats(store))


def each(title: str, calls: Sequence[tuple[Any, ...]], options: Options) -> list[Any]:
    """Call functions with arguments, (function, *arguments) each, by the experiment's workers.

    Returns:
        What they gave, in the order of the calls.
    """
    with _alone(options), options.crew() as crew:
        return run_all(title, [(function, tuple(rest)) for function, *rest in calls], crew, _beats(options.store))


def each_kept(title: str, calls: Mapping[Path, tuple[Any, ...]], options: Options) -> None:
    """Call functions, (function, *arguments) each, and keep what they give as JSON; what is kept is not done again.

    Args:
        title: for the progress.
        calls: by the paths of what they give.
        options: of the study.
    """
    for folder in {path.parent for path in calls}:
        folder.mkdir(parents=True, exist_ok=True)
    each(title, [(_keep, path, *call) for path, call in calls.items() if not path.is_file()], options)


def kept(path: Path) -> Any:
    """What `each_kept` kept; None where there is nothing."""
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else None


def _keep(path: Path, function: Callable[..., Any], *arguments: Any) -> None:
    write_json(path, function(*arguments))


@contextmanager
def _alone(options: Options) -> Iterator[None]:
    """Nobody else is at work on the experiment, so what a killed one left half-written can go."""
    with lock_folder(options.out):
        remove_drafts(options.out)
        yield


def finished(case: RecoveryCase, store: Path) -> bool:
    """Whether a case has its result."""
    return (store / case.name / _RESULT).is_file()


def state_of(case: RecoveryCase, store: Path) -> RunState:
    """The end of a finished run."""
    kept = _Kept.of(store / case.name / _CHECKPOINT)
    if kept is None:
        raise FileNotFoundError(f"{store / case.name} has no checkpoint")
    return kept.state


@dataclass(frozen=True)
class _Kept:
    """What a run's checkpoint holds.

    Attributes:
        state: of the run.
        wall_s: time that it took so far, in all processes that had it.
        taken_up: generations behind it each time that another process went on with it.
    """

    state: RunState = RunState()
    wall_s: float = 0.0
    taken_up: tuple[int, ...] = ()

    @classmethod
    def of(cls, path: Path) -> _Kept | None:
        """What was saved; None where nothing was."""
        saved = load_checkpoint(path)
        if saved is None:
            return None
        saved = saved if "state" in saved else {"state": saved}  # as it was before costs were kept
        return cls(**{**saved, "state": RunState.from_tree(saved["state"])})

    def save(self, path: Path) -> None:
        save_checkpoint(path, {**vars(self), "state": self.state.to_tree()})

    def again(self) -> _Kept:
        """Another process goes on."""
        return replace(self, taken_up=(*self.taken_up, len(self.state.history)))


def _first(case: RecoveryCase, store: Path) -> None:
    """The exploration that all cases of a seed begin with."""
    settings = case.settings.to_json()  # of damage and diagnosis, too, which have no part in it
    config = {name: settings[name] for name in ("seed", "population", "generations", "steps")}
    marker = {"experiment": "first walk", "config": config}
    folder = open_run(first_folder(case, store), resume=True, marker=marker, patience=math.inf)
    path = folder.file(_CHECKPOINT)
    _advanced(
        case, _Kept.of(path) or _Kept(), path, Heartbeat(_beats(store), f"first-{folder.path.name}"), until="damage"
    )


def _one(case: RecoveryCase, store: Path) -> None:
    marker = {"experiment": "recover", "config": case.settings.to_json()}
    folder = open_run(store / case.name, resume=True, marker=marker, patience=math.inf)
    if finished(case, store):
        return  # by another experiment, while we waited for the folder
    path = folder.file(_CHECKPOINT)
    kept, walked = _Kept.of(path), _Kept.of(first_folder(case, store) / _CHECKPOINT) or _Kept()
    kept = _Kept(walked.state) if kept is None else kept.again()
    kept = _advanced(case, kept, path, Heartbeat(_beats(store), case.name))
    found = run_record(kept.state, case.settings.axis, job(case).planted, case.settings.to_json())
    cost = {"wall_s": kept.wall_s, "taken_up": kept.taken_up, "residuals": kept.state.residuals}
    write_json(folder.file(_RESULT), {**case.labels(), **found, **cost, "versions": versions()})


def _advanced(case: RecoveryCase, kept: _Kept, path: Path, beat: Heartbeat, until: str = "done") -> _Kept:
    """Go on to a phase; saved now and then, and at the end."""
    parent, begin, last, before = os.getppid(), time.monotonic(), -math.inf, kept.wall_s
    if kept.state.phase == until:
        return kept
    with beat:
        course = with_true_damage if case.method == "oracle" else run_cycle
        for state in _until(course(job(case), kept.state), until):
            now = time.monotonic()
            kept = replace(kept, state=state, wall_s=before + now - begin)
            if now - last > _EVERY or state.phase == until:
                kept.save(path)
                last = now
            beat.report(_share(state, case), f"{state.phase} {state.number} of {case.settings.passes}")
            if os.getppid() != parent:
                raise SystemExit("the experiment that this worker belongs to is gone")
    return kept


def _until(states: Iterable[RunState], phase: str) -> Iterable[RunState]:
    for state in states:
        yield state
        if state.phase == phase:
            return


def _share(state: RunState, case: RecoveryCase) -> float:
    """How much of a run is behind it: phases, and generations of the one under way, which may end sooner."""
    phases = len(state.controllers) + len(state.diagnoses)
    rows = sum((row.phase, row.number) == (state.phase, state.number) for row in state.history)
    return min((phases + min(rows / case.settings.generations, 1.0)) / (2 * case.settings.passes + 1), 1.0)


def first_folder(case: RecoveryCase, store: Path) -> Path:
    """Of the walk that a case shares with others: they explore on the same simulators."""
    alone = case.settings.ensemble_size == 1
    return store / "first" / f"{case.robot}{'' if alone else '-ensemble'}-{case.seed}"


def _beats(store: Path) -> Path:
    return store / "under_way"
