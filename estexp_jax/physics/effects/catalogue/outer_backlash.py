"""Backlash inside a servo's loop: play between a rotor and the joint that the servo's encoder sees."""

from collections.abc import Mapping
from itertools import product
from typing import ClassVar, final

import jax.numpy as jnp
import mujoco
import numpy as np

from estexp_jax.physics.effects.base import NEVER, Array, Arrays, JointForce, JointState, Parameter, Term
from estexp_jax.physics.effects.guesses import Vectors, spread
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.rotor import holding_force, inertia_bounds, rotor_step
from estexp_jax.physics.effects.sites import driven_joint_sites, is_slide
from estexp_jax.physics.effects.spec_drives import SOONEST, add_play, behind_refusal
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot

_SUBSTEPS = 8
_STIFF = (0.02, 1.0)
"""Of the stiffest contact that the joint's own explicit step could follow."""

_DAMPED = 0.3
"""Damping ratio of the contact of steel gears."""


@register_effect
@final
class OuterBacklash(Term):
    """I da/dt = motor torque - tau, tau = k (x - s half_gap) + d (a - w) where x s > half_gap and tau s > 0, else 0.

    The rotor is x ahead of the joint, s = sign x, and turns at a; d = 2 zeta (k I)^(1/2). The motor's own loop sees the
    joint, by an encoder behind the play, so that it hunts; how fast depends on how the rotor rebounds. The rotor's
    inertia is taken from the joint's armature. It begins where the motor pushes it, and takes implicit sub-steps while
    the joint moves on at its speed; the joint gets their mean torque, with the damper's share implicitly. Reported as
    backlash.
    """

    name: ClassVar[str] = "outer_backlash"
    kind: ClassVar[str] = "joint"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("half_gap", "rad"),
        Parameter("I", "kg m2"),
        Parameter("k", "N m/rad"),
        Parameter("zeta", ""),
    )
    equation: ClassVar[str] = "tau = k (x - half_gap) + d (a - w) where the rotor is x > half_gap ahead and pushes"
    in_mjcf: ClassVar[bool] = True
    extends_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "Nordin and Gutman, Controlling mechanical systems with backlash, Automatica 38 (2002)"
    n_states: ClassVar[int] = 3
    motor_torque_state: ClassVar[int | None] = 2
    variant_of: ClassVar[str] = "backlash"

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return driven_joint_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        stiffest = scales.joint_inertia(robot, robot.index("joint", site)) / float(robot.model.opt.timestep) ** 2
        play, (soft, stiff) = 0.02 if is_slide(robot, site) else 0.2, (share * stiffest for share in _STIFF)
        return (0.0, play), inertia_bounds(robot, site), (soft, stiff), (0.05, 1.0)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"between the joint {site} and its motor there is a play of {values['half_gap']:.3g} rad to either side"

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        play, inertia, stiffness, _ = self.bounds(robot, site)
        [rotor], plays = spread(inertia, 1), np.geomspace(0.03, 0.5, 5) * play[1]
        return [(gap, rotor, k, _DAMPED) for gap, k in product(plays.tolist(), spread(stiffness, 2))]

    def reported_as(self, values: Mapping[str, float]) -> tuple[str, Mapping[str, float]]:
        return "backlash", {"half_gap": values["half_gap"]}

    def initial(self, p: Arrays, q: Array, w: Array) -> Arrays:
        return jnp.full_like(q, NEVER), w, jnp.zeros_like(q)

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        (gap, inertia, k, zeta), (x, a, _), (q, w) = p, state, (joint.q, joint.w)
        x = jnp.where(x == NEVER, jnp.sign(joint.torque) * gap, x)
        d, motor, h = 2.0 * zeta * jnp.sqrt(k * inertia), holding_force(joint), joint.dt / _SUBSTEPS
        push = braking = jnp.zeros_like(q)
        for _ in range(_SUBSTEPS):
            r, q, end = q + x, q + h * w, jnp.where(x > 0.0, gap, -gap)
            free_r, free, _ = rotor_step(motor, r, a, h, inertia)
            held_r, held_a, _ = rotor_step(motor, r, a, h, inertia, (k, q + end), (d, w))
            tau = k * (held_r - q - end) + d * (held_a - w)
            pushes = (jnp.abs(r - q) > gap) & (tau * end > 0.0)
            push = push + pushes * (tau + d * w) / _SUBSTEPS
            braking = braking + pushes * d / _SUBSTEPS
            x, a = jnp.where(pushes, held_r, free_r) - q, jnp.where(pushes, held_a, free)
        has_play = gap > 0.0
        does = JointForce(
            force=jnp.where(has_play, push, 0.0),
            damping=jnp.where(has_play, braking, 0.0),
            inertia=jnp.where(has_play, -jnp.minimum(inertia, joint.armature), 0.0),
            motor=jnp.where(has_play, 0.0, 1.0),
        )
        return does, (jnp.where(has_play, x, 0.0), jnp.where(has_play, a, w), jnp.where(has_play, joint.torque, 0.0))

    def mjcf_refusal(self, robot: Robot, site: str, values: Mapping[str, float]) -> str:
        return behind_refusal(robot, site)

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        zeta, frequency = values["zeta"], np.sqrt(values["k"] / values["I"])
        ends = max(1.0 / (zeta * frequency), SOONEST * float(spec.option.timestep)), zeta
        add_play(robot, spec, site, values["half_gap"], values["I"], ends)
