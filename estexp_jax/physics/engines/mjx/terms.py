"""Terms, command laws and body forces at work in one step of one robot on MJX.

The laws are elementwise over their sites; here is what gathers the sites from a robot's arrays and scatters back.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, NamedTuple, final

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from mujoco import mjx

from estexp_jax.physics.effects.base import Arrays, BodyForce, CommandLaw, JointForce, JointState, Term
from estexp_jax.physics.effects.changes import Values
from estexp_jax.physics.effects.elements import element_values
from estexp_jax.physics.effects.registry import Catalogue
from estexp_jax.physics.effects.sites import driven_actuators
from estexp_jax.physics.engines.mjx.carried import mount_states, torques_of_weight
from estexp_jax.physics.engines.motors import (
    Drives,
    drives,
    idle_commands,
    limited_commands,
    motor_load,
    motor_torque,
    motor_torques,
)
from estexp_jax.physics.model.robot import Robot

Hidden = dict[str, Arrays]
"""Hidden variables (n_elements,) of each effect that has some, by its name."""


class MjxStepStart(NamedTuple):
    """A robot at the beginning of a step."""

    qpos: Any  #: (nq,)
    qvel: Any  #: (nv,)
    ctrl: Any  #: (nu,) command in force
    enable: Any  #: (nu,) 1.0 where the motor is on
    dt: Any  #: length of the step, s


class EffectForces(NamedTuple):
    """Inputs of a physics step, and hidden variables after it."""

    model: mjx.Model
    ctrl: jax.Array  #: (nu,)
    force: jax.Array  #: (nv,) added to the joints
    pull: jax.Array  #: (nbody, 6) added to the bodies
    hidden: Hidden


@final
@dataclass(frozen=True, eq=False)
class _Step:
    """One step while its terms act one after the other.

    Attributes:
        robot, now: what it is a step of.
        model: with damping and friction of the terms so far, motors unscaled.
        share: (nu,) factors on the motors so far.
        force: (nv,).
    """

    robot: Robot
    now: MjxStepStart
    model: mjx.Model
    share: jax.Array
    force: jax.Array

    def scaled(self) -> mjx.Model:
        """The model with its motors scaled: gain, bias and force range together, so that limits scale with them."""
        share = self.share[:, None]
        return self.model.replace(
            actuator_gainprm=self.model.actuator_gainprm * share,
            actuator_biasprm=self.model.actuator_biasprm * share,
            actuator_forcerange=self.model.actuator_forcerange * share,
        )


def stateful(catalogue: Catalogue) -> list[Term | CommandLaw]:
    """The effects with hidden variables."""
    return [e for e in catalogue if isinstance(e, Term | CommandLaw) and e.n_states]


def hidden_at_rest(robot: Robot, catalogue: Catalogue, values: Values, now: MjxStepStart, model: mjx.Model) -> Hidden:
    """Hidden variables of a robot that has been where it is, under this command, for long."""
    hidden: Hidden = {}
    for e in stateful(catalogue):
        p = _at_elements(e, robot, values)
        if isinstance(e, Term):
            q, w = _coordinates(robot, e.dofs(robot), now)
            hidden[e.name] = e.initial(p, q, w)
        else:
            hidden[e.name] = e.initial(p, limited_commands(model, now.ctrl)[e.actuators(robot)])
    return hidden


def apply_effects(
    robot: Robot, catalogue: Catalogue, model: mjx.Model, values: Values, hidden: Hidden, now: MjxStepStart
) -> EffectForces:
    """Let all effects of a catalogue act that do so during a step, in its order: command laws, then terms, pulls."""
    hidden = dict(hidden)
    now, hidden = _with_command_laws(robot, catalogue, model, values, hidden, now)
    nominal = jnp.ones(robot.model.nu, now.qvel.dtype)
    step = _Step(robot, now, model, nominal, jnp.zeros(robot.model.nv, now.qvel.dtype))
    for e in catalogue:
        if isinstance(e, Term) and e.sites(robot):
            p = _at_elements(e, robot, values)
            dofs = e.dofs(robot)
            there = drives(robot, dofs, e.motors(robot))
            does, state = e.act(p, _joint_state(step, e, dofs, there), hidden.get(e.name, ()))
            hidden |= {e.name: state} if e.n_states else {}
            step = _applied(step, does, dofs, there)
    model = step.model if step.share is nominal else step.scaled()
    pull = _pulled(robot, catalogue, model, values, now)
    return EffectForces(without_slope_at_limits(robot, model, step.now), step.now.ctrl, step.force, pull, hidden)


def _columns(values: jax.Array) -> Arrays:
    return tuple(values[:, i] for i in range(values.shape[1]))


def _at_elements(e: Term | CommandLaw, robot: Robot, values: Values) -> Arrays:
    return _columns(element_values(e, robot, values[e.name]))


def _coordinates(robot: Robot, dofs: np.ndarray, now: MjxStepStart) -> tuple[jax.Array, jax.Array]:
    return now.qpos[robot.model.jnt_qposadr[robot.model.dof_jntid[dofs]]], now.qvel[dofs]


def _with_command_laws(
    robot: Robot, catalogue: Catalogue, model: mjx.Model, values: Values, hidden: Hidden, now: MjxStepStart
) -> tuple[MjxStepStart, Hidden]:
    laws = [e for e in catalogue if isinstance(e, CommandLaw) and e.sites(robot)]
    if not laws:
        return now, hidden
    ctrl, driven = limited_commands(model, now.ctrl), np.array(driven_actuators(robot), dtype=int)
    dofs = np.array([robot.model.jnt_dofadr[robot.joint_of_actuator(int(a))] for a in driven], dtype=int)
    idle = jnp.zeros_like(ctrl).at[driven].set(idle_commands(model, driven, *_coordinates(robot, dofs, now)))
    for e in laws:
        a = e.actuators(robot)
        command, state = e.act(_at_elements(e, robot, values), ctrl[a], idle[a], now.dt, hidden.get(e.name, ()))
        ctrl = ctrl.at[a].set(command)
        hidden = hidden | ({e.name: state} if e.n_states else {})
    return now._replace(ctrl=ctrl), hidden


def _joint_state(step: _Step, e: Term, dofs: np.ndarray, there: Drives) -> JointState:
    robot, model, now = step.robot, step.scaled(), step.now
    q, w = _coordinates(robot, dofs, now)
    command = limited_commands(model, now.ctrl)

    def torque_at(q: jax.Array, w: jax.Array) -> jax.Array:
        return there.torque(model, q, w, command)

    def torque_of(number: jax.Array) -> jax.Array:
        each = motor_torques(robot, model, now.qpos, now.qvel, now.ctrl)[robot.model.jnt_dofadr]
        joint = number.astype(jnp.int32) - 1
        return jnp.where(joint >= 0, each[jnp.clip(joint, 0, robot.model.njnt - 1)], 0.0)

    def motion_of(number: jax.Array) -> tuple[jax.Array, jax.Array]:
        scalar = np.array(robot.scalar_joints, dtype=int)
        mine = jnp.round(number)[:, None] == jnp.asarray(scalar + 1.0)
        every = _coordinates(robot, robot.model.jnt_dofadr[scalar], now)
        at, speed = (jnp.where(mine, x, 0.0).sum(axis=1) for x in every)
        return at, speed

    return JointState(
        q=q,
        w=w,
        torque=torque_at(q, w),
        on=there.on(now.enable),
        dt=now.dt,
        limit=there.limit().astype(np.float32),
        armature=model.dof_armature[dofs],
        torque_at=torque_at,
        torque_of=torque_of,
        motion_of=motion_of,
        asked=lambda: there.asked(model, q, w, command),
        load=lambda: motor_load(robot, model, now.qpos, now.qvel, command),
        gravity=lambda: torques_of_weight(robot, model, now.qpos)[dofs],
        mount=lambda: mount_states(robot, model, e.bodies(robot), dofs, now.qpos, now.qvel),
    )


def _applied(step: _Step, does: JointForce, dofs: np.ndarray, there: Drives) -> _Step:
    """The step with what a term does; numbers are the defaults, which change nothing."""

    def is_set(x: Any) -> bool:
        return not isinstance(x, float)

    changed = {}
    for field, added in (
        ("dof_damping", does.damping),
        ("dof_frictionloss", does.friction),
        ("dof_armature", does.inertia),
    ):
        if is_set(added):
            changed[field] = getattr(step.model, field).at[dofs].add(added)
    model = step.model.replace(**changed) if changed else step.model
    force = step.force.at[dofs].add(does.force) if is_set(does.force) else step.force
    share = there.scaled(step.share, does.motor) if is_set(does.motor) else step.share
    now = step.now
    if is_set(does.command):
        now = now._replace(ctrl=there.further(step.scaled(), limited_commands(step.model, now.ctrl), does.command))
    return replace(step, now=now, model=model, force=force, share=share)


def _pulled(robot: Robot, catalogue: Catalogue, model: mjx.Model, values: Values, now: MjxStepStart) -> jax.Array:
    pull = jnp.zeros((robot.model.nbody, 6), now.qvel.dtype)
    body_forces = [e for e in catalogue if isinstance(e, BodyForce) and e.sites(robot)]
    if not body_forces:
        return pull
    place = mjx.kinematics(model, mjx.make_data(robot.model).replace(qpos=now.qpos)).xipos
    for e in body_forces:
        bodies = np.array([robot.index("body", site) for site in e.sites(robot)], dtype=int)
        x, y, z = (place[bodies, axis] for axis in range(3))
        pull = pull.at[bodies, :3].add(jnp.stack(e.force_on_body(_columns(values[e.name]), (x, y, z)), axis=1))
    return pull


def without_slope_at_limits(robot: Robot, model: mjx.Model, now: MjxStepStart) -> mjx.Model:
    """The model with motors at their force limit as constant forces, for the integrator that derives forces by speed.

    A motor at its limit does not brake, which the C engine knows and MJX 3.17 does not: on the leg's knee, its servo's
    kv would slow a saturated motor by a fifth.
    """
    braking = (model.actuator_biastype == int(mujoco.mjtBias.mjBIAS_AFFINE)) & (model.actuator_forcelimited > 0)
    a = np.array([i for i in driven_actuators(robot) if braking[i]], dtype=int)
    if not a.size or model.opt.integrator != mujoco.mjtIntegrator.mjINT_IMPLICITFAST:
        return model
    dofs = np.array([robot.model.jnt_dofadr[robot.joint_of_actuator(int(i))] for i in a], dtype=int)
    q, w = _coordinates(robot, dofs, now)
    gear = model.actuator_gear[a, 0]
    force = motor_torque(model, a, q, w, limited_commands(model, now.ctrl)[a]) / jnp.where(gear == 0.0, 1.0, gear)
    low, high = model.actuator_forcerange[a, 0], model.actuator_forcerange[a, 1]
    at_limit = ((force <= low) | (force >= high)) & (low < high)
    gain, bias = model.actuator_gainprm, model.actuator_biasprm
    constant = jnp.zeros_like(bias[a]).at[:, 0].set(force)
    return model.replace(
        actuator_gainprm=gain.at[a].set(jnp.where(at_limit[:, None], 0.0, gain[a])),
        actuator_biasprm=bias.at[a].set(jnp.where(at_limit[:, None], constant, bias[a])),
    )
