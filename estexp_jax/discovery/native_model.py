"""What `model_explained.xml` holds: the values as they were found, at the user's step, judged by stepping the file.

What MJCF has no place for is left out, and nothing else is fitted anew to stand in for it. Training recordings choose;
test recordings only say how far the file is off.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import final

import mujoco
import numpy as np

from estexp_jax.discovery.diagnosis import Case, NativeModel
from estexp_jax.discovery.export import explained_spec
from estexp_jax.discovery.findings import told_change
from estexp_jax.discovery.intervals import ratio_interval
from estexp_jax.discovery.problem import Problem
from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.effects.written import mjcf_refusal
from estexp_jax.physics.engines.c.histories import lengthen_histories
from estexp_jax.physics.engines.c.plain_replay import PlainReplay
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.window import Window

Refusal = Callable[[Robot, Change], str]
"""Why a file has no place for a change of a robot; empty where it has one."""
_MOST_WINDOWS = 16
"""Windows of training recordings on which files are compared: they are stepped one by one."""
_PLAINLY = 2.0
"""Convention: squared error by which a second file has to be better to be written."""


def as_found(robot: Robot, change: Change, refusal: Refusal = mjcf_refusal) -> Change | None:
    """A change as MJCF holds it: itself, or as it is reported; None where there is no place for either."""
    return next((c for c in (change, told_change(change)) if not refusal(robot, c)), None)


def native_model(
    case: Case,
    shown: Problem,
    claimed: Sequence[Change],
    others: Sequence[Change],
    refitted: Sequence[Change],
    *,
    finer: int,
    fine_only: bool,
    seed: int,
    refusal: Refusal = mjcf_refusal,
) -> NativeModel:
    """What the file of an explanation holds.

    Args:
        case: what was explained.
        shown: the comparison as the results show it.
        claimed: what was found.
        others: values of the model that were fitted beside it; they are left as they were, unless that costs.
        refitted: what was fitted without what MJCF cannot hold.
        finer: part of the model's own step that the explained simulator takes.
        fine_only: whether the user's step is what is wrong.
        seed: of the resampling.
        refusal: why the file has no place for a change.
    """
    robot, stepped, own = case.robot, Stepped(case, shown), finer if fine_only else 1
    held = [c for c in (as_found(robot, c, refusal) for c in claimed) if c is not None]
    kept, failed = _compiling(robot, held)
    refused = [(c, refusal(robot, c)) for c in claimed if as_found(robot, c, refusal) is None]
    left_out = (*refused, *((c, "it does not go with the others") for c in failed))
    train = stepped.some_of("train")
    changes = kept
    if others:
        both = _compiling(robot, [*kept, *others])[0]
        both_costs = [stepped.costs(c, own, train) for c in (kept, both)]
        changes = both if ratio_interval(both_costs[0], both_costs[1], seed)[0] > 1.0 else kept
    fine, stand_in = False, None
    if changes and (finer > own or left_out):
        costs = stepped.costs(changes, own, train)
        fine = finer > own and ratio_interval(costs, stepped.costs(changes, finer, train), seed)[0] > _PLAINLY
        if left_out:
            other = _compiling(robot, [c for c in refitted if not refusal(robot, c)])[0]
            better = ratio_interval(costs, stepped.costs(other, own, train), seed)[0] > _PLAINLY
            stand_in = other if better else None
    test = shown.windows_of(case.indices("test"))
    errors = {role: stepped.error(changes, own, windows) for role, windows in (("train", train), ("test", test))}
    return NativeModel(changes, left_out, errors, own, fine, stand_in)


@final
class Stepped:
    """Files of a case, stepped by MuJoCo alone in the windows that are shown."""

    def __init__(self, case: Case, shown: Problem) -> None:
        self._case, self._problem = case, shown
        self._readings: dict[tuple[str, int, int], np.ndarray] = {}

    def some_of(self, role: str) -> np.ndarray:
        """Indices of at most so many windows of recordings of a role, evenly spread."""
        windows = self._problem.windows_of(self._case.indices(role))
        n = min(len(windows), _MOST_WINDOWS)
        return windows[np.linspace(0, len(windows) - 1, n).round().astype(int)]

    def costs(self, changes: Sequence[Change], finer: int, windows: np.ndarray) -> np.ndarray:
        """Mean squared errors over squared ranges (windows,); of what blew up, large ones."""
        readings = self._stepped(tuple(changes), finer, windows)
        shares = self._problem.recorded.shares_of(readings, windows)
        sampled = np.isfinite(self._problem.recorded.readings(windows))
        bad = np.where(np.isfinite(shares), shares, _BLOWN_UP)
        return np.array([b[s].mean() if s.any() else 0.0 for b, s in zip(bad, sampled, strict=True)])

    def error(self, changes: Sequence[Change], finer: int, windows: np.ndarray) -> float:
        """The nrmse in some windows."""
        return self._problem.recorded.error_of(self._stepped(tuple(changes), finer, windows), windows)

    def _stepped(self, changes: tuple[Change, ...], finer: int, windows: np.ndarray) -> np.ndarray:
        """Readings (windows, rows, channels), each window simulated once."""
        problem, robots = self._problem, self._case.robots
        cut, name = problem.replays.cut.whole, repr(changes)
        missing = [int(w) for w in windows if (name, finer, int(w)) not in self._readings]
        for robot in {id(robots[cut[w].recording]): robots[cut[w].recording] for w in missing}.values():
            own = [w for w in missing if robots[cut[w].recording] is robot]
            step = float(robot.model.opt.timestep) / finer
            segments = [cut[w] if finer == 1 else cut[w].stepped(step) for w in own]
            replay = PlainReplay(robot, stepped_model(robot, changes, segments), changes=changes)
            for w, readings in zip(own, problem.channels.simulated(replay.replay(segments)), strict=True):
                self._readings[name, finer, w] = readings
            problem.counted[0] += sum(s.steps.n_steps for s in segments)
        rows = max(cut[w].rows for w in windows)
        found = np.full((len(windows), rows, len(problem.channels.names)), np.nan)
        for i, w in enumerate(windows):
            readings = self._readings[name, finer, int(w)][:rows]
            found[i, : len(readings)] = readings
        return found


_EVEN = 1e-3
"""Share by which steps may differ and count as even."""
_BLOWN_UP = 100.0
"""Squared error, over the squared range, of a simulation that is no number."""


def stepped_model(robot: Robot, changes: Sequence[Change], windows: Sequence[Window]) -> mujoco.MjModel:
    """The file's model at the step that windows take: one that ends on each row, so perhaps a little shorter.

    Where rows are uneven, steps are too; then buffers of delays hold more of the shorter ones.
    """
    lengths = np.concatenate([w.steps.length[w.steps.length > 0.0] for w in windows])
    step = float(np.median(lengths))
    spec = explained_spec(robot, changes, float(robot.model.opt.timestep) / step)
    if lengths.min() < (1.0 - _EVEN) * step:
        lengthen_histories(spec)
    return spec.compile()


def _compiling(robot: Robot, changes: Sequence[Change]) -> tuple[tuple[Change, ...], tuple[Change, ...]]:
    """The changes that one description holds together, and those that do not go with the ones before."""
    if _compiles(robot, changes):
        return tuple(changes), ()
    kept = list[Change]()
    for change in changes:
        if _compiles(robot, [*kept, change]):
            kept.append(change)
    return tuple(kept), tuple(c for c in changes if c not in kept)


def _compiles(robot: Robot, changes: Sequence[Change]) -> bool:
    try:
        explained_spec(robot, changes)
    except (ValueError, RuntimeError, mujoco.FatalError):
        return False
    return True
