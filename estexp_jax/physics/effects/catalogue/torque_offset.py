"""Torque offset: a constant torque at a joint."""

from collections.abc import Mapping
from typing import ClassVar, final

import mujoco

from estexp_jax.physics.effects.base import Arrays, JointForce, JointState, Parameter, Term
from estexp_jax.physics.effects.new_elements import CONSTANT, add_passive_motor
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import scalar_joint_sites
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot


@register_effect
@final
class TorqueOffset(Term):
    """tau = T, whatever the joint does: a cable's pull, a current sensor's offset."""

    name: ClassVar[str] = "torque_offset"
    kind: ClassVar[str] = "joint"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("T", "N m", signed=True),)
    equation: ClassVar[str] = "tau = T"
    in_mjcf: ClassVar[bool] = True
    extends_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "constant generalised force; MuJoCo: actuator/dcmotor, cogging without poles"
    additive: ClassVar[bool] = True
    is_constant_torque: ClassVar[bool] = True
    beside_laws: ClassVar[bool] = True

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return scalar_joint_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        most = 0.5 * scales.joint_torque(robot, robot.index("joint", site))
        return ((-most, most),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"a constant torque of {values['T']:+.3g} N m acts on the joint {site}"

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        (T,) = p
        return JointForce(force=T), state

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        add_passive_motor(spec, f"{site}_offset", site, cogging=[values["T"], *CONSTANT])
