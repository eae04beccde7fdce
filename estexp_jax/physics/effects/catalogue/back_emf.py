"""Back-EMF: a motor brakes in proportion to its speed, as long as it is on."""

from collections.abc import Mapping, Sequence
from typing import ClassVar, final

import mujoco

from estexp_jax.physics.effects.base import Arrays, JointForce, JointState, Parameter, Term
from estexp_jax.physics.effects.friction import friction_advice
from estexp_jax.physics.effects.passive import add_damper
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.servos import servo_damping_at
from estexp_jax.physics.effects.sites import actuator_sites
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording


@register_effect
@final
class BackEmf(Term):
    """tau = -k w while the motor is on; integrated implicitly, as joint damping.

    MJCF holds it as damping of the joint, which does the same as long as the motor is on. As a servo's `kv` it would
    be clipped with the force, and a DC motor's constant would be explicit under Euler.
    """

    name: ClassVar[str] = "back_emf"
    kind: ClassVar[str] = "actuator"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("k", "N m s/rad"),)
    equation: ClassVar[str] = "tau = -k w while the motor is on"
    in_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "DC motor: k = k_t k_e / R"
    additive: ClassVar[bool] = True
    alike_while_on: ClassVar[str] = "viscous_friction"

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return actuator_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return ((0.0, scales.motor_limit(robot, robot.index("actuator", site))),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"the motor {site}, while it is on, brakes with {values['k']:.3g} N m for each rad/s of speed"

    def nominal_value(self, robot: Robot, site: str) -> float:
        return servo_damping_at(robot, site)

    def advice(self, recordings: Sequence[Recording]) -> tuple[str, ...]:
        return friction_advice(recordings)

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        (k,) = p
        return JointForce(damping=k * joint.on), state

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        joint = robot.joint_of_actuator(robot.index("actuator", site))
        assert joint is not None, "it acts at joints alone"
        add_damper(robot, spec, robot.names("joint")[joint], (values["k"], 0.0, 0.0))
