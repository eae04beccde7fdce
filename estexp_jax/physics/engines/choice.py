"""Which engine simulates a robot: lanes where they can; else C, or on a GPU MJX."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from estexp_jax.errors import InputError, known
from estexp_jax.lanes.capabilities import refusal
from estexp_jax.physics.effects.base import CommandShift, ReadingDrift, ReadingShift
from estexp_jax.physics.effects.controller_fault import ControllerFault
from estexp_jax.physics.effects.registry import Catalogue
from estexp_jax.physics.engines.batching import EngineChoice
from estexp_jax.physics.engines.c.closed_loop import CClosedLoop, c_width
from estexp_jax.physics.engines.c.lane_models import recorded_fields
from estexp_jax.physics.engines.c.open_loop import C_REPLAY, COpenLoop
from estexp_jax.physics.engines.closed_loop import ClosedLoopSimulator
from estexp_jax.physics.engines.closed_loop_agreement import Agreement, closed_loop_agreement, sample_states
from estexp_jax.physics.engines.controller_interface import interface_of
from estexp_jax.physics.engines.devices import accelerated
from estexp_jax.physics.engines.lanes.closed_loop import LanesClosedLoop, lanes_width
from estexp_jax.physics.engines.lanes.model import lanes_refusal
from estexp_jax.physics.engines.lanes.open_loop import LANES_REPLAY, LanesOpenLoop
from estexp_jax.physics.engines.mjx.capabilities import reduced_to_mjx
from estexp_jax.physics.engines.mjx.closed_loop import MjxClosedLoop, mjx_width
from estexp_jax.physics.engines.mjx.model import MjxModel, mjx_model
from estexp_jax.physics.engines.mjx.open_loop import MJX_REPLAY, MjxOpenLoop
from estexp_jax.physics.engines.open_loop import OpenLoopSimulator
from estexp_jax.physics.engines.open_loop_agreement import open_loop_agreement
from estexp_jax.physics.engines.per_recording_model import per_recording_model
from estexp_jax.physics.engines.policy import Policy
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.window import Window

Engine = Literal["auto", "lanes", "c", "mjx"]
ENGINES: Sequence[Engine] = ("auto", "lanes", "c", "mjx")
_CLOSED_LOOPS: Mapping[str, type[ClosedLoopSimulator]] = {
    "lanes": LanesClosedLoop,
    "c": CClosedLoop,
    "mjx": MjxClosedLoop,
}
_STATES = 32
"""States from which closed loops are tried against the C engine before they are believed."""


def choose_engine(
    engine: str, on_mjx: MjxModel, overridden: frozenset[str] = frozenset(), instead: str = "mjx"
) -> EngineChoice:
    """The engine for a robot that MJX takes.

    Args:
        engine: what the user wants: auto, lanes or mjx.
        on_mjx: the robot and the effects it is to carry.
        overridden: fields that recordings' known settings change.
        instead: the engine for what lanes refuse.

    Raises:
        InputError: there is no such engine, or lanes are wanted and cannot simulate the robot.
    """
    _refuse_unknown(engine)
    if engine == "mjx":
        return EngineChoice("mjx", "as asked for")
    refused = lanes_refusal(on_mjx, overridden)
    if refused is None:
        return EngineChoice(
            "lanes", "as asked for" if engine == "lanes" else "the fastest that can simulate this robot"
        )
    if engine == "lanes":
        raise InputError(f"{refused} by the lanes engine", where=on_mjx.robot.source, right=f"use --engine {instead}")
    return EngineChoice(instead, f"{refused} by the lanes engine")


def _refuse_unknown(engine: str) -> None:
    if engine not in ENGINES:
        raise InputError(f"there is no engine '{engine}'", where="--engine", right=known(ENGINES))


def left_out_by(engine: str, robot: Robot) -> tuple[str, ...]:
    """What open loops leave out of a robot with this engine; each follows "simulated without"."""
    if engine == "c":
        return ()
    try:
        without = reduced_to_mjx(robot).left_out
        if without and engine == "auto" and not accelerated() and lanes_refusal(mjx_model(robot, ())) is not None:
            return ()
    except InputError:  # beyond MJX: it runs on C, or is refused when it is to be simulated
        return ()
    return without


def closed_loop_simulator(
    robot: Robot,
    catalogue: Catalogue,
    *,
    policy: Policy,
    rows: int,
    control_step: float,
    population: int = 200,
    engine: str = "auto",
) -> ClosedLoopSimulator:
    """Compile-ready simulator of a robot in closed loop.

    Args:
        robot: the nominal robot.
        catalogue: effects that may be planted; none of them a `CommandShift`, `ReadingShift` or `ReadingDrift`.
        policy: the controllers' equations.
        rows: longest rollout, control steps.
        control_step: s; rounded to whole physics steps.
        population: robots that will be simulated at once, or twice as many as are new each time.
        engine: auto, lanes, c or mjx.

    Raises:
        InputError: no engine simulates the robot as MuJoCo does, or not the one that is wanted.
    """
    _refuse_unknown(engine)
    timed = [e.name for e in catalogue if isinstance(e, CommandShift | ReadingShift | ReadingDrift)]
    if timed:
        raise ValueError(f"not simulated in closed loop: {', '.join(timed)}")
    catalogue = tuple(e.for_controller(policy.n_hidden) if isinstance(e, ControllerFault) else e for e in catalogue)
    substeps = max(1, int(np.round(control_step / robot.model.opt.timestep)))
    face = interface_of(robot)
    states = sample_states(robot, face, _STATES)
    widths = {"lanes": lanes_width, "c": c_width, "mjx": mjx_width}
    tried: list[str] = []
    for name in _candidates(engine):
        reason = "as asked for" if engine != "auto" else "; ".join(tried) or "the fastest that can simulate this robot"
        try:
            if name == "lanes":
                choose_engine("lanes", mjx_model(robot, catalogue), instead="mjx" if accelerated() else "c")
            made = _CLOSED_LOOPS[name](
                robot, catalogue, face, policy, rows, substeps, widths[name](population), EngineChoice(name, reason)
            )
            found = closed_loop_agreement(made, states, converged=name != "c")
        except InputError as error:
            if engine != "auto":
                raise
            tried.append(error.what)
            continue
        if found.agrees:
            return made
        tried.append(f"the {name} engine, as compiled here, {found.sentence()}")
    raise InputError("; ".join((*tried, *_unusual(robot))), where=robot.source, right=_instead(engine))


def open_loop_simulator(
    robot: Robot,
    catalogue: Catalogue,
    per_recording: Sequence[Robot],
    *,
    engine: str = "auto",
    windows: Sequence[Window] = (),
    width: int | None = None,
    block: int | None = None,
) -> OpenLoopSimulator:
    """An open-loop simulator for recordings of a robot, of the first engine that agrees with plain MuJoCo on it.

    Args:
        robot: the nominal robot.
        catalogue: the effects that hypotheses draw on.
        per_recording: the nominal robot with each recording's known settings.
        engine: auto, lanes, c or mjx.
        windows: of the recordings; engines are compared with MuJoCo from their states, among others.
        width: lanes in a chunk; None: what suits the engine.
        block: physics steps in a call; None: what suits the engine.

    Raises:
        InputError: no engine simulates the model as MuJoCo does, or not the one that is wanted; or a recording's
            settings change the model's structure.
    """
    _refuse_unknown(engine)
    tried: list[str] = []
    reason = "as asked for"
    for name in _candidates(engine):
        try:
            simulator = _built(name, robot, catalogue, per_recording, width, block)
        except InputError as error:
            if engine != "auto":
                raise
            reason = error.what
            tried.append(reason)
            continue
        found = _open_loop_agreement(simulator, per_recording[0], windows)
        if found.agrees:
            if engine == "auto" and not tried:
                reason = "the fastest that can simulate this robot"
            return replace(simulator, choice=EngineChoice(name, reason, found.largest))
        reason = f"the {name} engine, as it runs here, {found.sentence()}"
        tried.append(reason)
    raise InputError("; ".join((*tried, *_unusual(robot))), where=robot.source, right=_instead(engine))


def _instead(engine: str) -> str:
    """What to do where an engine, or all of them, simulate another robot than MuJoCo does."""
    if engine == "auto":
        return "leave out of the model what differs"
    return "use --engine " + {"lanes": "mjx" if accelerated() else "c", "mjx": "c"}.get(engine, "auto")


def _unusual(robot: Robot) -> tuple[str, ...]:
    """What a robot has beyond the common, in words, by which a difference may be explained."""
    reason = refusal(robot.model)
    return () if reason is None else (f"the model has {re.sub(' (is|are) not supported$', '', reason)}",)


def _candidates(engine: str) -> tuple[str, ...]:
    """Engines to be tried for open loops, in turns."""
    if engine != "auto":
        return (engine,)
    return ("lanes", "mjx", "c") if accelerated() else ("lanes", "c", "mjx")


def _built(
    name: str,
    robot: Robot,
    catalogue: Catalogue,
    per_recording: Sequence[Robot],
    width: int | None,
    block: int | None,
) -> OpenLoopSimulator:
    """An open-loop simulator on an engine, not yet compared; see `open_loop_simulator`."""
    choice = EngineChoice(name, "")
    if name == "c":
        recorded = recorded_fields(robot, per_recording)
        return COpenLoop(robot, catalogue, width or C_REPLAY[0], block or C_REPLAY[1], choice, recorded)
    nominal = mjx_model(robot, catalogue)
    differs = per_recording_model(nominal, per_recording)
    if name == "mjx":
        return MjxOpenLoop(robot, catalogue, width or MJX_REPLAY[0], block or MJX_REPLAY[1], choice, nominal, differs)
    choose_engine("lanes", nominal, differs.fields, "mjx" if accelerated() else "c")
    return LanesOpenLoop(robot, catalogue, width or LANES_REPLAY[0], block or LANES_REPLAY[1], choice, nominal, differs)


def _open_loop_agreement(simulator: OpenLoopSimulator, robot: Robot, windows: Sequence[Window]) -> Agreement:
    """Its distance from plain MuJoCo; the C engine, which compiles nothing, is tried in chunks of the usual size."""
    if isinstance(simulator, COpenLoop):
        usual = replace(simulator, width=C_REPLAY[0], block=C_REPLAY[1])
        return open_loop_agreement(usual, robot, windows, converged=False)
    return open_loop_agreement(simulator, robot, windows)
