"""Whether an engine simulates the same physics as MuJoCo's C engine: one step from states that robots visit.

The C engine is the referee, with its solver run until it has converged, on models compiled with the robots' changes in
their description. So the check covers what an engine makes of an edit as well as its step.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, final

import mujoco
import numpy as np

from estexp_jax.physics.effects.base import Edit, Term
from estexp_jax.physics.effects.changes import Change, encode, stack
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.engines.closed_loop import ClosedLoopSimulator
from estexp_jax.physics.engines.controller_interface import Interface
from estexp_jax.physics.model.robot import Robot

MEDIAN, HIGH = 1e-4, 1e-2
"""Largest errors with which an engine counts as right: the median, and the 95th percentile. Single precision gives
medians of some 1e-6; a contact that opens or closes within rounding gives an outlier; a solver that was stopped after
one iteration is wrong by metres a second in a tenth of the states."""

_EVERY = 23
"""Physics steps between two visited states under one command."""
_WALK = 16
"""States visited before the robot starts again from home, so that not all lie on their backs."""


class SampledStates(NamedTuple):
    """States of the nominal robot, (n, ...), and the network outputs in [-1, 1] (n, nu) with which it goes on."""

    qpos: np.ndarray
    qvel: np.ndarray
    warmstart: np.ndarray
    outputs: np.ndarray


@final
@dataclass(frozen=True)
class Agreement:
    """Distance of an engine from the converged C engine.

    Errors are those of the velocities after one control step: per state the largest over the degrees of freedom, in
    m/s or rad/s, relative to the robot's largest velocity where that is more than 1.

    Attributes:
        states: how many were compared.
        physics_steps: in the control step.
        median, high, largest: of the errors; `high` is the 95th percentile.
        differing: where the engine differs, in words; empty where it agrees.
    """

    states: int
    physics_steps: int
    median: float
    high: float
    largest: float
    differing: str = ""

    @property
    def agrees(self) -> bool:
        """Whether it is the same physics."""
        return bool(self.median <= MEDIAN and self.high <= HIGH) and not self.differing  # false for NaN

    def sentence(self) -> str:
        """In words."""
        verdict = "agrees with" if self.agrees else "differs from"
        where = f" in {self.differing}" if self.differing else ""
        return (
            f"{verdict} plain MuJoCo{where}: error after {self.physics_steps} physics step(s) from {self.states} "
            f"states median {self.median:.1e}, 95 % {self.high:.1e}, largest {self.largest:.1e}"
        )


def sample_states(robot: Robot, face: Interface, n: int, seed: int = 0) -> SampledStates:
    """States that the nominal robot passes through in the C engine under random commands, rounded to float32."""
    return _wandered(robot, lambda outputs: commands_of(face, outputs), n, seed)


def _wandered(robot: Robot, commands: Callable[[np.ndarray], np.ndarray], n: int, seed: int) -> SampledStates:
    rng, model = np.random.default_rng(seed), robot.model
    data, rows = mujoco.MjData(model), []
    for k in range(n):
        if k % _WALK == 0:
            mujoco.mj_resetData(model, data)
            data.qpos[:] = robot.home()
        outputs = rng.uniform(-1.0, 1.0, model.nu)
        data.ctrl[:] = commands(outputs)
        mujoco.mj_step(model, data, _EVERY)
        outputs = rng.uniform(-1.0, 1.0, model.nu)
        rows.append((data.qpos.copy(), data.qvel.copy(), data.qacc_warmstart.copy(), outputs))
    return SampledStates(*(np.array(column, np.float32) for column in zip(*rows, strict=True)))


def commands_of(face: Interface, outputs: np.ndarray) -> np.ndarray:
    """Commands (..., nu) of network outputs (..., nu), in double precision."""
    return np.clip(face.ctrl_centre + face.ctrl_scale * outputs.astype(float), face.ctrl_low, face.ctrl_high)


def referee_speeds(
    robot: Robot,
    face: Interface,
    states: SampledStates,
    substeps: int,
    sets: Sequence[Sequence[Change]] = ((),),
    *,
    converged: bool = True,
) -> np.ndarray:
    """Velocities (n, nv) after one control step in the C engine.

    Args:
        robot: the nominal robot.
        face: of its controllers.
        states: where it starts.
        substeps: physics steps in the control step.
        sets: changes of robots, taken in turns by the states; none of them loses a part.
        converged: whether its solver runs until it has converged, or as the robot's options say.
    """
    models = [_changed(robot, changes, converged=converged) for changes in sets]
    return _stepped(models, states, commands_of(face, states.outputs), substeps)


def _stepped(models: Sequence[mujoco.MjModel], states: SampledStates, commands: np.ndarray, steps: int) -> np.ndarray:
    found = []
    for k, ctrl in enumerate(commands):
        model = models[k % len(models)]
        data = mujoco.MjData(model)
        data.qpos[:], data.qvel[:], data.qacc_warmstart[:] = states.qpos[k], states.qvel[k], states.warmstart[k]
        data.ctrl[:] = ctrl
        mujoco.mj_step(model, data, steps)
        found.append(data.qvel.copy())
    return np.array(found)


def engine_speeds(
    simulator: ClosedLoopSimulator, states: SampledStates, sets: Sequence[Sequence[Change]] = ((),)
) -> np.ndarray:
    """The same of an engine."""
    n = len(states.qpos)
    values = stack([encode(simulator.robot, simulator.catalogue, sets[k % len(sets)]) for k in range(n)])
    start = simulator.home(values)._replace(qpos=states.qpos, qvel=states.qvel, warmstart=states.warmstart)
    weights = simulator.policy.constant(states.outputs, simulator.interface.n_inputs)
    return np.asarray(simulator.rollout(values, weights, start, 1).final.qvel)


def engine_agreement(found: np.ndarray, expected: np.ndarray, substeps: int) -> Agreement:
    """Distance of an engine's velocities (n, nv) from those of the referee."""
    scale = np.maximum(1.0, np.abs(expected).max(axis=1))
    error = np.abs(found - expected).max(axis=1) / scale
    error = np.sort(np.where(np.isfinite(error), error, np.inf))
    median, high = (float(error[int(share * (len(error) - 1))]) for share in (0.5, 0.95))
    return Agreement(len(error), substeps, median, high, float(error[-1]))


def closed_loop_agreement(
    simulator: ClosedLoopSimulator,
    states: SampledStates,
    sets: Sequence[Sequence[Change]] = ((),),
    *,
    converged: bool = True,
) -> Agreement:
    """Distance of a closed-loop engine from the referee, with the one executable of its rollouts.

    Args:
        simulator: the engine.
        states: where to start, as `sample_states` gives them.
        sets: changes of robots, taken in turns by the states; from the simulator's catalogue.
        converged: whether the referee's solver runs until it has converged, or as the robot's options say.
    """
    face = simulator.interface
    expected = referee_speeds(simulator.robot, face, states, simulator.substeps, sets, converged=converged)
    return engine_agreement(engine_speeds(simulator, states, sets), expected, simulator.substeps)


def _changed(robot: Robot, changes: Sequence[Change], *, converged: bool) -> mujoco.MjModel:
    spec = robot.spec.copy()
    for change in changes:
        e = effect(change.effect)
        if not isinstance(e, Edit | Term):
            raise ValueError(f"'{change.effect}' has no place in MJCF")
        e.write_mjcf(robot, spec, change.name or "", {p.name: p.neutral for p in e.parameters} | {**change.parameters})
    model = spec.compile()
    if converged:
        model.opt.iterations, model.opt.ls_iterations, model.opt.tolerance = 100, 50, 1e-12
    return model
