"""Backlash: play between a motor and its joint."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax.numpy as jnp
import mujoco

from estexp_jax.physics.effects.base import Array, Arrays, JointForce, JointState, Parameter, Term
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.rotor import rotor_step
from estexp_jax.physics.effects.sites import driven_joint_sites, is_slide
from estexp_jax.physics.effects.spec_drives import add_play
from estexp_jax.physics.model.robot import Robot

_SUBSTEPS = 4
_FREE = 1e-4
"""Of the play: so far from its end is a rotor that rebounds."""


class Play(Term):
    """The rotor turns freely within |x| < half_gap, x = its angle less the joint's; at either end it pushes the joint.

    Its inertia is the joint's armature, or part of it, which the joint has only while they touch; where they meet, the
    joint gets the rotor's momentum, and they move on as one, or the rotor rebounds in the next step. The motor's own
    loop sees the rotor, as most servos' encoders do. It takes implicit sub-steps; the joint gets their mean push, with
    the motor's braking implicitly.
    """

    kind: ClassVar[str] = "joint"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("half_gap", "rad"),)
    equation: ClassVar[str] = "tau = motor torque where the rotor is half_gap ahead and pushes on, else 0"
    in_mjcf: ClassVar[bool] = True
    extends_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "Nordin and Gutman, Controlling mechanical systems with backlash, Automatica 38 (2002)"
    n_states: ClassVar[int] = 4
    motor_torque_state: ClassVar[int | None] = 2

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return driven_joint_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return ((0.0, 0.02 if is_slide(robot, site) else 0.2),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"between the joint {site} and its motor there is a play of {values['half_gap']:.3g} rad to either side"

    def rotor(self, p: Arrays, joint: JointState) -> Array:
        """The rotor's inertia, kg m2."""
        return joint.armature

    def restitution(self, p: Arrays) -> Array:
        """Share of the speed at which they meet that the rotor leaves the joint with."""
        return jnp.zeros_like(p[0])

    def initial(self, p: Arrays, q: Array, w: Array) -> Arrays:
        return jnp.zeros_like(q), w, jnp.zeros_like(q), jnp.zeros_like(q)

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        gap = p[0]
        x, a, _, thrown = state
        bounces = thrown != 0.0
        x, a = x * (1.0 - _FREE * bounces), a + bounces * (joint.w + thrown - a)
        q, w, inertia, h = joint.q, joint.w, self.rotor(p, joint), joint.dt / _SUBSTEPS
        thrown = push = braking = separated = motor_torque = jnp.zeros_like(q)
        for _ in range(_SUBSTEPS):
            q = q + h * w
            touched = jnp.abs(x) >= gap
            _, a, slope = rotor_step(joint, q + x, jnp.where(touched, w, a), h, inertia)
            x = x + h * (a - w)
            touches = jnp.abs(x) >= gap
            x = jnp.clip(x, -gap, gap)
            torque = joint.torque_at(q + x, w)
            motor_torque = motor_torque + torque / _SUBSTEPS
            stays = (touched & touches & (torque * x >= 0.0)) / _SUBSTEPS
            hits, back = touches & ~touched, self.restitution(p) * (a - w)
            # A flight shorter than a step is none.
            back = back * (hits & (2.0 * inertia * jnp.abs(back) > jnp.abs(torque) * joint.dt))
            thrown = thrown - back
            push = push + stays * torque + hits * inertia * (a - w + back) / joint.dt
            braking = braking - stays * slope
            separated = separated + ~(touched | touches) / _SUBSTEPS
            a = jnp.where(touches, w, a)
        has_play, lost = gap > 0.0, jnp.minimum(inertia, joint.armature)
        does = JointForce(
            force=jnp.where(has_play, push + braking * w, 0.0),
            damping=jnp.where(has_play, braking, 0.0),
            inertia=jnp.where(has_play, inertia * (separated != 1.0) - lost, 0.0),
            motor=jnp.where(has_play, 0.0, 1.0),
        )
        return does, (x, a, jnp.where(has_play, motor_torque, 0.0), thrown)


@register_effect
@final
class Backlash(Play):
    """With a rotor that has the joint's armature, and does not rebound."""

    name: ClassVar[str] = "backlash"

    def mjcf_refusal(self, robot: Robot, site: str, values: Mapping[str, float]) -> str:
        return "" if rotor_armature(robot, site) > 0.0 else "the joint has no armature, so its rotor no inertia"

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        add_play(robot, spec, site, values["half_gap"], rotor_armature(robot, site))


def rotor_armature(robot: Robot, joint: str) -> float:
    """Armature of a joint in the model, kg m2 or kg."""
    return float(robot.model.dof_armature[robot.model.jnt_dofadr[robot.index("joint", joint)]])
