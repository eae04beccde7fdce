"""The C engine as referee: converged, on recompiled descriptions, mapped to the nominal robot by joint names."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import mujoco
import numpy as np

from estexp_jax.physics.effects.base import Edit, Term
from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.model.robot import Robot

TRAJECTORY = 20
"""Physics steps of a short trajectory."""


class States(NamedTuple):
    """Visited states of the nominal robot's size, (n, ...), and what the C engine made of them."""

    qpos: np.ndarray
    qvel: np.ndarray
    ctrl: np.ndarray
    warmstart: np.ndarray
    next_qvel: np.ndarray  #: after one step
    final_qpos: np.ndarray  #: after TRAJECTORY steps under the same command
    contacts: np.ndarray  #: how many were active


def converged(model: mujoco.MjModel) -> mujoco.MjModel:
    """The same model with a solver that leaves no error worth naming; changed in place."""
    model.opt.iterations, model.opt.ls_iterations, model.opt.tolerance = 100, 50, 1e-12
    return model


def recompiled(robot: Robot, changes: Sequence[Change]) -> mujoco.MjModel:
    """The robot with these changes written into its description, compiled."""
    spec = robot.spec.copy()
    for change in changes:
        e = effect(change.effect)
        assert isinstance(e, Edit | Term)
        e.write_mjcf(
            robot, spec, change.name or "", {p.name: p.neutral for p in e.parameters} | dict(change.parameters)
        )
    return converged(spec.compile())


class Mapping(NamedTuple):
    """Where the elements of a smaller model lie in the nominal one."""

    qpos: np.ndarray
    dof: np.ndarray
    actuator: np.ndarray
    body: np.ndarray

    def widen(self, robot: Robot, qpos: np.ndarray, qvel: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """A state of the smaller model as one of the nominal robot: lost joints at home, at rest."""
        full_qpos, full_qvel = robot.home(), np.zeros(robot.model.nv)
        full_qpos[self.qpos], full_qvel[self.dof] = qpos, qvel
        return full_qpos, full_qvel


def mapping(robot: Robot, model: mujoco.MjModel) -> Mapping:
    """By names: every element of `model` has one, given by `Robot.from_spec` if not by its author."""
    nominal = robot.model
    joints = [(j, robot.index("joint", model.joint(j).name)) for j in range(model.njnt)]

    def addresses(small: np.ndarray, full: np.ndarray, size: int) -> np.ndarray:
        ends = [*small[1:], size]
        return np.concatenate([full[k] + np.arange(ends[j] - small[j]) for j, k in joints])

    return Mapping(
        addresses(model.jnt_qposadr, nominal.jnt_qposadr, model.nq),
        addresses(model.jnt_dofadr, nominal.jnt_dofadr, model.nv),
        np.array([robot.index("actuator", model.actuator(a).name) for a in range(model.nu)], dtype=int),
        np.array([0] + [robot.index("body", model.body(b).name) for b in range(1, model.nbody)], dtype=int),
    )


def nothing(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """No term acts."""


def visit(
    robot: Robot,
    model: mujoco.MjModel,
    *,
    seed: int,
    n: int,
    every: int = 23,
    term: Callable[[mujoco.MjModel, mujoco.MjData], None] = nothing,
) -> States:
    """States that `model`, a changed `robot`, passes through under random commands, each followed by its future.

    Args:
        term: called before each physics step; may change the model's parameters of that step.
    """
    rng, where = np.random.default_rng(seed), mapping(robot, model)
    data, branch = mujoco.MjData(model), mujoco.MjData(model)
    data.qpos[:] = robot.home()[where.qpos]
    low, high = command_limits(robot)
    rows = []
    for _ in range(n):
        ctrl = rng.uniform(low, high)
        data.ctrl[:] = ctrl[where.actuator]
        for _ in range(every):
            term(model, data)
            mujoco.mj_step(model, data)
        qpos, qvel = where.widen(robot, data.qpos, data.qvel)
        warmstart = np.zeros(robot.model.nv)
        warmstart[where.dof] = data.qacc_warmstart
        branch.qpos[:], branch.qvel[:], branch.ctrl[:] = data.qpos, data.qvel, data.ctrl
        branch.qacc_warmstart[:] = data.qacc_warmstart
        term(model, branch)
        mujoco.mj_step(model, branch)
        contacts, next_qvel = branch.ncon, where.widen(robot, branch.qpos, branch.qvel)[1]
        for _ in range(TRAJECTORY - 1):
            term(model, branch)
            mujoco.mj_step(model, branch)
        final = where.widen(robot, branch.qpos, branch.qvel)[0]
        rows.append((qpos, qvel, ctrl, warmstart, next_qvel, final, contacts))
    return States(*(np.array(column) for column in zip(*rows, strict=True)))


def command_limits(robot: Robot) -> tuple[np.ndarray, np.ndarray]:
    """Range to draw commands from: a little more than the control range, so that it is met, else +-1."""
    limited = robot.model.actuator_ctrllimited[:, None].astype(bool)
    low, high = np.where(limited, 1.1 * robot.model.actuator_ctrlrange, [-1.0, 1.0]).T
    return low, high
