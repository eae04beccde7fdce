"""Crosstalk: a joint feels a share of another joint's motor."""

from collections.abc import Mapping
from itertools import product
from typing import ClassVar, final

import mujoco

from estexp_jax.physics.effects.base import Arrays, JointForce, JointState, Parameter, Term
from estexp_jax.physics.effects.guesses import Vectors, other_elements
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import driven_joint_sites, scalar_joint_sites
from estexp_jax.physics.effects.spec_drives import motors_of
from estexp_jax.physics.effects.spec_forces import add_share, share_refusal
from estexp_jax.physics.model.robot import Robot


@register_effect
@final
class Crosstalk(Term):
    """tau = g * motor torque of joint `from`: tendons or cables that pass a joint on their way."""

    name: ClassVar[str] = "crosstalk"
    kind: ClassVar[str] = "joint"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("from", "1 + joint index", refers="joint"),
        Parameter("g", "", signed=True),
    )
    equation: ClassVar[str] = "tau = g (motor torque of joint `from`)"
    in_mjcf: ClassVar[bool] = True
    extends_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "coupled tendon transmissions: Siciliano et al., Robotics (2009), section 5.1"

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return scalar_joint_sites(robot) if len(driven_joint_sites(robot)) > 1 else ()

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return (1.0, float(robot.model.njnt)), (-1.0, 1.0)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        share, source = 100 * values["g"], int(values["from"])
        return f"the joint {site} receives {share:.3g} % of the motor torque of joint number {source}"

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        others = other_elements(robot, "joint", site)
        return list(product(others, (-0.3, -0.1, 0.1, 0.3)))

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        source, g = p
        return JointForce(force=g * joint.torque_of(source)), state

    def mjcf_refusal(self, robot: Robot, site: str, values: Mapping[str, float]) -> str:
        source = robot.names("joint")[int(values["from"]) - 1]
        return share_refusal(robot, source) if source != site else "a joint feels all of its own motor"

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        source = robot.names("joint")[int(values["from"]) - 1]
        add_share(robot, spec, motors_of(robot, source), site, values["g"])
