"""Changes written into a description, each by its effect: all that MJCF has a place for."""

from __future__ import annotations

from collections.abc import Iterable

import mujoco
import numpy as np

from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.effects.new_elements import ROTOR
from estexp_jax.physics.effects.registry import effect, every
from estexp_jax.physics.model.actuators import HAS_DECLARED_INPUTS
from estexp_jax.physics.model.robot import Robot

_WIDTHS = {mujoco.mjtJoint.mjJNT_FREE: (7, 6), mujoco.mjtJoint.mjJNT_BALL: (4, 3)}
"""Coordinates and speeds of joints; of others one each."""


def mjcf_refusal(robot: Robot, change: Change) -> str:
    """Why MJCF has no place for a change of a robot; empty where it has one."""
    name, own = change.name or "", effect(change.effect)
    if (refusal := own.mjcf_refusal(robot, name, change.values)) or HAS_DECLARED_INPUTS:
        return refusal
    try:
        own.write_mjcf(robot, robot.spec.copy(), name, change.values)
    except NotImplementedError as error:
        return str(error)
    return ""


def written(robot: Robot, changes: Iterable[Change]) -> mujoco.MjSpec:
    """A description of the robot, at its own step, with the changes in it for which MJCF has a place; not compiled.

    Effects write in the order of the catalogue, what loses parts last, so that each finds its element.
    """
    spec, order = robot.spec.copy(), {e.name: i for i, e in enumerate(every())}
    for change in sorted(changes, key=lambda c: (effect(c.effect).removes_part, order[c.effect])):
        if not mjcf_refusal(robot, change):
            effect(change.effect).write_mjcf(robot, spec, change.name or "", change.values)
    _fit_keyframes(robot, spec)
    return spec


def joint_addresses(model: mujoco.MjModel, joint: int) -> tuple[np.ndarray, np.ndarray]:
    """Addresses of a joint's coordinates and speeds."""
    n_qpos, n_qvel = _WIDTHS.get(mujoco.mjtJoint(model.jnt_type[joint]), (1, 1))
    return model.jnt_qposadr[joint] + np.arange(n_qpos), model.jnt_dofadr[joint] + np.arange(n_qvel)


def same_joints(robot: Robot, model: mujoco.MjModel) -> list[tuple[int, int]]:
    """Indices in a model and in the robot's of each joint that both have, and of each rotor and the joint it is of."""
    found, names = [], {name: j for j, name in enumerate(robot.names("joint"))}
    for j in range(model.njnt):
        name = model.joint(j).name
        base = name if name in names else name.rpartition(ROTOR)[0]
        if base in names:
            found.append((j, names[base]))
    return found


def carried_over(
    robot: Robot, model: mujoco.MjModel, qpos: np.ndarray, qvel: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """A state of the robot as one of a model of it that has more joints or fewer; rotors are where their joints are."""
    there, moving = model.qpos0.copy(), np.zeros(model.nv)
    for j, own in same_joints(robot, model):
        (q, v), (own_q, own_v) = joint_addresses(model, j), joint_addresses(robot.model, own)
        there[q], moving[v] = qpos[own_q], qvel[own_v]
    return there, moving


def _fit_keyframes(robot: Robot, spec: mujoco.MjSpec) -> None:
    """Give keyframes the coordinates, speeds and activations that were added to a description, or take away."""
    if not robot.model.nkey:
        return
    bare = spec.copy()
    for key in list(bare.keys):
        bare.delete(key)
    model, nominal = bare.compile(), robot.model
    if (model.nq, model.nv, model.na, model.nu) == (nominal.nq, nominal.nv, nominal.na, nominal.nu):
        return
    for k, key in enumerate(spec.keys):
        key.qpos, moving = carried_over(robot, model, nominal.key_qpos[k], nominal.key_qvel[k])
        key.qvel = moving if moving.any() else []
        act, ctrl = np.zeros(model.na), np.zeros(model.nu)
        for a in range(model.nactuator):
            if (name := model.actuator(a).name) in robot.names("actuator"):
                own = robot.index("actuator", name)
                _copy(act, model.actuator_actadr[a], model.actuator_actnum[a], nominal.key_act[k], nominal, own)
                n = int(model.actuator_ctrlnum[a])
                first, from_ = int(model.actuator_ctrladr[a]), int(nominal.actuator_ctrladr[own])
                if n > 0:
                    ctrl[first : first + n] = nominal.key_ctrl[k][from_ : from_ + n]
        key.act, key.ctrl = act if act.any() else [], ctrl if ctrl.any() else []


def _copy(act: np.ndarray, first: int, n: int, before: np.ndarray, nominal: mujoco.MjModel, own: int) -> None:
    """Activations of one actuator, as far as it had some."""
    had = int(nominal.actuator_actnum[own])
    if first >= 0 and had > 0:
        start, kept = int(nominal.actuator_actadr[own]), min(had, int(n))
        act[first : first + kept] = before[start : start + kept]
