"""Joint compliance: a motor moves its joint through a spring."""

from collections.abc import Mapping
from itertools import product
from typing import ClassVar, final

import jax.numpy as jnp
import mujoco

from estexp_jax.physics.effects.base import NEVER, Array, Arrays, JointForce, JointState, Parameter, Term
from estexp_jax.physics.effects.guesses import Bounds, Vectors, spread
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.rotor import holding_force, rotor_step
from estexp_jax.physics.effects.sites import driven_joint_sites
from estexp_jax.physics.effects.spec_drives import add_spring_drive, behind_refusal
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot

_SUBSTEPS = 4


class Compliance(Term):
    """I da/dt = motor torque - tau, dr/dt = a; tau = k (r - q) + d (a - w) on the joint.

    The rotor at r turns at a, behind spring k and damper d. Within a step the
    rotor takes implicit sub-steps while the joint moves on at its speed, so no stiffness makes it unstable; the joint
    gets the mean torque of the sub-steps, and the damper's share implicitly.
    """

    #: Whether the motor's own loop sees the rotor, or the joint.
    collocated: ClassVar[bool]
    kind: ClassVar[str] = "joint"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("k", "N m/rad", neutral=NEVER),
        Parameter("d", "N m s/rad"),
        Parameter("I", "kg m2"),
    )
    equation: ClassVar[str] = "tau = k (r - q) + d (a - w), I da/dt = motor torque - tau, dr/dt = a"
    in_mjcf: ClassVar[bool] = True
    extends_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "Spong, Modeling and control of elastic joint robots, J. Dyn. Sys. Meas. Control 109 (1987)"
    n_states: ClassVar[int] = 3
    motor_torque_state: ClassVar[int | None] = 2
    nested_in: ClassVar[str] = "armature"

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return driven_joint_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        joint = robot.index("joint", site)
        inertia, step = scales.joint_inertia(robot, joint), float(robot.model.opt.timestep)
        stiffest = inertia / step**2  # beyond, the joint's own explicit step could not follow
        return (7e-4 * stiffest, stiffest), (0.0, 0.2 * inertia / step), (0.01 * inertia, 3.0 * inertia)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return (
            f"the motor of the joint {site}, with a rotor of {values['I']:.3g} kg m2, moves it through a spring "
            f"of {values['k']:.3g} N m/rad with a damping of {values['d']:.3g} N m s/rad"
        )

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        stiffness, damping, inertia = self.bounds(robot, site)
        return [(k, 0.1 * damping[1], i) for k, i in product(spread(stiffness, 4), spread(inertia, 2))]

    def from_simpler(self, simpler: Mapping[str, float], bounds: Bounds) -> Vectors:
        inertia = max(simpler["I"], 1e-6)
        return [(inertia * w**2, 0.2 * inertia * w, inertia) for w in (30.0, 60.0, 120.0, 240.0)]

    def to_simpler(self, values: Mapping[str, float]) -> Vectors:
        return [(values["I"],)]

    def initial(self, p: Arrays, q: Array, w: Array) -> Arrays:
        return q, w, jnp.zeros_like(q)

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        (k, d, inertia), (r, a, _), (q, w) = p, state, (joint.q, joint.w)
        joint = joint if self.collocated else holding_force(joint)
        is_soft, h = k < NEVER, joint.dt / _SUBSTEPS
        spring = torque = 0.0
        for _ in range(_SUBSTEPS):
            q = q + h * w
            torque = torque + joint.torque_at(r, a) / _SUBSTEPS
            r, a, _ = rotor_step(joint, r, a, h, inertia, (k, q), (d, w))
            spring = spring + (k * (r - q) + d * a) / _SUBSTEPS
        does = JointForce(
            force=jnp.where(is_soft, spring, 0.0),
            damping=jnp.where(is_soft, d, 0.0),
            motor=jnp.where(is_soft, 0.0, 1.0),
        )
        return does, (jnp.where(is_soft, r, joint.q), jnp.where(is_soft, a, w), jnp.where(is_soft, torque, 0.0))

    def mjcf_refusal(self, robot: Robot, site: str, values: Mapping[str, float]) -> str:
        return "" if self.collocated else behind_refusal(robot, site)

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        add_spring_drive(robot, spec, site, values["I"], values["k"], values["d"])


@register_effect
@final
class JointCompliance(Compliance):
    """The motor's own loop sees the rotor, as most servos' encoders do."""

    name: ClassVar[str] = "joint_compliance"
    collocated: ClassVar[bool] = True
