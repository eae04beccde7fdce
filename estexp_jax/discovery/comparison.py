"""What of a case is compared with what: its simulator, the windows that are fitted, those that are shown."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np

from estexp_jax.discovery.diagnosis import Case, ExplainConfig
from estexp_jax.discovery.hypotheses import claimable, simulated, singles
from estexp_jax.discovery.possible import possible
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.recorded import deviations
from estexp_jax.discovery.replays import Replays
from estexp_jax.discovery.shorter_windows import SHARE
from estexp_jax.estimation.channels import channels_of
from estexp_jax.estimation.missing_commands import with_missing_rows
from estexp_jax.estimation.windows import fitting_window, window_set_of
from estexp_jax.physics.effects.registry import catalogue
from estexp_jax.physics.engines.choice import open_loop_simulator
from estexp_jax.physics.engines.open_loop import OpenLoopSimulator
from estexp_jax.physics.model.clearance import NEAR, TOGETHER, without_collisions
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.window import Window

_WINDOWS, _WORK = (16, 48), 144_000
"""Fewest and most windows that are fitted of long recordings, and how often forces at a robot's joints are computed in
them."""


def problem_of(case: Case, config: ExplainConfig, memory: dict[str, Any]) -> Problem:
    """The comparison of a case, with windows of the configured length.

    Raises:
        InputError: the model cannot be simulated, or there is no reading to compare.
    """
    recordings = tuple(map(with_missing_rows, case.recordings))
    every = singles(case.robot, catalogue(claimable(config.effects)))
    places = tuple(p for p in every if possible(case.robot, p, recordings))
    cut = window_set_of(case.robots, recordings, config.window)
    apart = apart_in(case, cut.whole, case.indices("train"))
    simulator = replayer_of(case, config, simulated(config.effects), apart, cut.whole)
    channels = channels_of(case.robot, recordings)
    left = np.array([case.discrepancy.get(name, 0.0) for name in channels.names])
    noise = np.hypot(deviations(channels, recordings), left)
    replays = Replays(simulator, channels, cut, standing=case.standing)
    problem = Problem(replays, recordings, memory, noise, places)
    return replace(problem, most=_most_windows(case.robot, cut.whole))


def replayer_of(
    case: Case,
    config: ExplainConfig,
    effects: Sequence[str],
    apart: Sequence[tuple[int, int]],
    windows: Sequence[Window],
) -> OpenLoopSimulator:
    """Of the robots with effects of these names, without contacts between some pairs of their bodies.

    The windows are the states from which engines are compared with MuJoCo; those of training recordings are.
    """
    robot, *robots = _each(lambda r: r.without_contacts(apart), (case.robot, *case.robots))
    train = [w for w in windows if w.recording in case.indices("train")]
    known = catalogue(dict.fromkeys([*effects, *(change.effect for change in case.standing)]))
    return open_loop_simulator(robot, known, robots, engine=config.engine, windows=train)


def apart_in(
    case: Case, segments: Sequence[Window], recordings: Sequence[int], near: float = NEAR
) -> list[tuple[int, int]]:
    """Pairs of bodies that some recordings, whose paths are known, never brought near each other."""
    paths = {s.recording: s.path.qpos for s in segments if s.path is not None and s.recording in recordings}
    return without_collisions(case.robot, list(paths.values()), near) if len(paths) == len(recordings) else []


def shown_of(case: Case, config: ExplainConfig, whole: Problem) -> Problem:
    """The comparison that is shown: where test recordings bring parts together, these may touch."""
    fitted = apart_in(case, whole.segments, case.indices("train"))
    every = apart_in(case, whole.segments, range(len(case.recordings)), TOGETHER)
    near = set(fitted) - set(every)
    if not near:
        return whole
    simulator = replayer_of(
        case, config, [e.name for e in whole.replayer.catalogue], sorted(set(fitted) - near), whole.segments
    )
    return replace(whole, replays=replace(whole.replays, replayer=simulator))


def _most_windows(robot: Robot, segments: Sequence[Window]) -> int:
    """So many windows are fitted at most: minutes of one motion teach little more, and cost as much more.

    A robot of more joints has more hypotheses, too, each dearer to simulate.
    """
    stages = 4 if int(robot.model.opt.integrator) == int(mujoco.mjtIntegrator.mjINT_RK4) else 1
    work = stages * max(s.steps.n_steps for s in segments) * max(robot.model.nv, 3)
    return int(np.clip(_WORK // work, *_WINDOWS))


def to_fit(case: Case, config: ExplainConfig, whole: Problem) -> Problem:
    """The comparison that is fitted, perhaps with shorter windows."""
    window = fitting_window(case.robot, config.window)
    if window == config.window:
        return whole
    return whole.with_windows(window_set_of(case.robots, whole.recordings, window))


def shortened(case: Case, config: ExplainConfig, whole: Problem) -> Problem:
    """The comparison in shorter windows than usual."""
    cut = window_set_of(case.robots, whole.recordings, SHARE * config.window)
    memory = whole.memory.setdefault("shorter windows", {})
    return replace(whole.with_windows(cut), memory=memory, most=_most_windows(case.robot, cut.whole), hairs=True)


def _each(change: Callable[[Robot], Robot], robots: Sequence[Robot]) -> list[Robot]:
    """A change of each robot, of the same one only once."""
    known = {id(r): change(r) for r in {id(r): r for r in robots}.values()}
    return [known[id(r)] for r in robots]
