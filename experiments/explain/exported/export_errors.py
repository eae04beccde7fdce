"""How far simulators are off on a case's test recordings: nominal, as found, the written file, and `explained.py`."""

from __future__ import annotations

import json
import sys
import types
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from estexp_jax.api.explain import cases_of
from estexp_jax.discovery.diagnosis import Case
from estexp_jax.discovery.export import explained_spec
from estexp_jax.discovery.native_model import Stepped, as_found
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.recorded import deviations
from estexp_jax.discovery.replays import Replays
from estexp_jax.estimation.channels import channels_of
from estexp_jax.estimation.windows import window_set_of
from estexp_jax.physics.effects.changes import Change, encode, stack
from estexp_jax.physics.effects.registry import catalogue, every
from estexp_jax.physics.engines.c.plain_replay import PlainReplay, Stepper
from estexp_jax.physics.engines.choice import open_loop_simulator
from estexp_jax.physics.engines.standalone.script import explained_script
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recordings.inputs import read_inputs

_WINDOW = 2.0
"""Length of windows, s, as `explain` has it."""


def export_errors(
    manifest: Path, changes: Sequence[Change], step: float | None = None, finer: int = 1
) -> dict[str, Any]:
    """Errors (nrmse) on test recordings.

    Args:
        manifest: of the recordings.
        changes: what was found.
        step: of the model, s; None: its own.
        finer: part of that step which the simulator that found them takes.

    Returns:
        `nominal`; `found`, at the simulator's step; `found_at_step`, at the model's; `file`, stepped by MuJoCo alone;
        `file_and_script` and `script`, with `explained.py` over the file and over the nominal model; `left_out`, what
        the file has not.
    """
    case = _at_step(cases_of(read_inputs([str(manifest)]))[0], step)
    names = {c.effect for c in changes}
    effects = tuple(e for e in every() if e.name in names) or catalogue(["viscous_friction"])
    simulator = open_loop_simulator(case.robot, effects, list(case.robots), engine="c")
    channels = channels_of(case.robot, case.recordings)
    cut = window_set_of(case.robots, case.recordings, _WINDOW)
    problem = Problem(Replays(simulator, channels, cut), case.recordings, {}, deviations(channels, case.recordings), ())
    test = problem.windows_of(case.indices("test"))

    def found(own: Sequence[Change], parts: int) -> float:
        windows = [cut.whole[w] for w in test]
        segments = [w if parts == 1 else w.stepped(_step_of(case, w) / parts) for w in windows]
        values = stack([encode(case.robot, effects, own)] * len(test))
        readings = channels.simulated(simulator.replay(values, segments, np.arange(len(test))))
        return problem.recorded.error_of(readings, test)

    pairs = [(c, as_found(case.robot, c)) for c in changes]
    held = [own for _, own in pairs if own is not None]
    marked = [(c, own is not None) for c, own in pairs]
    errors = {
        "nominal": found((), 1),
        "found": found(changes, finer),
        "found_at_step": found(changes, 1),
        "file": Stepped(case, problem).error(held, 1, test),
        "left_out": [c.place for c, own in pairs if own is None],
    }
    for name, over, parts in (("file_and_script", held, 1), ("script", (), finer)):
        errors[name] = _by_script(case, problem, test, marked, over, held, parts)
    return errors


def _by_script(
    case: Case,
    problem: Problem,
    test: np.ndarray,
    marked: Sequence[tuple[Change, bool]],
    held: Sequence[Change],
    native: Sequence[Change],
    finer: int,
) -> float:
    """The error of `explained.py` over a model that holds some changes itself."""
    cut, readings = problem.replays.cut.whole, list[np.ndarray]()
    for w in test:
        robot = case.robots[cut[w].recording]
        script = _module(explained_script(robot, marked, finer, explained_spec(robot, native).compile()))
        model = explained_spec(robot, held).compile()

        def begin(model: mujoco.MjModel, data: mujoco.MjData, script: Any = script) -> Stepper:
            script.install(model, data)
            return script.step

        readings.append(
            problem.channels.simulated(PlainReplay(robot, model, begin, [c for c, _ in marked]).replay([cut[w]]))[0]
        )
    rows = max(len(r) for r in readings)
    table = np.full((len(test), rows, readings[0].shape[1]), np.nan)
    for i, one in enumerate(readings):
        table[i, : len(one)] = one
    return problem.recorded.error_of(table, test)


def _module(text: str) -> Any:
    module = types.ModuleType("explained")
    sys.modules["explained"] = module
    exec(compile(text, "explained.py", "exec"), module.__dict__)  # noqa: S102 (what a user would import)
    return module


def _at_step(case: Case, step: float | None) -> Case:
    """The case with its model at another step."""
    if step is None:
        return case
    parts = float(case.robot.model.opt.timestep) / step
    known: dict[int, Robot] = {id(r): r.finer(parts) for r in {id(r): r for r in (case.robot, *case.robots)}.values()}
    return Case(known[id(case.robot)], case.recordings, tuple(known[id(r)] for r in case.robots))


def _step_of(case: Case, window: Any) -> float:
    return float(case.robots[window.recording].model.opt.timestep)


def changes_of(folder: Path) -> tuple[tuple[Change, ...], int]:
    """What an explanation found, or what was planted; and the part of the step that its simulator takes."""
    for name, key in (("effects.json", "changes"), ("truth.json", "effects")):
        if (folder / name).is_file():
            kept = json.loads((folder / name).read_text(encoding="utf-8"))
            return tuple(map(Change.from_json, kept[key])), int(kept.get("finer", 1))
    raise FileNotFoundError(folder)
