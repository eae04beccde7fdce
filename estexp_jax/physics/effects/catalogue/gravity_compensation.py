"""Gravity compensation: a drive adds, unasked and unlogged, torque that cancels gravity at its joint."""

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import ClassVar, final

import mujoco
import numpy as np

from estexp_jax.physics.effects.base import Arrays, JointForce, JointState, Parameter, Term
from estexp_jax.physics.effects.guesses import Vectors
from estexp_jax.physics.effects.new_elements import free_name
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import ALL_ALIKE, driven_joint_sites, with_all
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot, spec_element
from estexp_jax.physics.recording import Recording

_FELT = 1e-3
"""Share of a joint's largest torque that gravity puts on it at least, where compensating it is anything."""


@register_effect
@final
class GravityCompensation(Term):
    """tau = -share * (torque of gravity at the joint), while its motor is on.

    The torque of gravity is that of the weight of all that the joint carries: axis . ((centre - anchor) x weight).
    """

    name: ClassVar[str] = "gravity_compensation"
    kind: ClassVar[str] = "joint"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("share", "", signed=True),)
    equation: ClassVar[str] = "tau = -share (torque of gravity at the joint)"
    in_mjcf: ClassVar[bool] = True
    extends_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = (
        "gravity compensation: Siciliano et al., Robotics (2009), section 8.5.1; MuJoCo: body/gravcomp"
    )
    flags: ClassVar[tuple[str, ...]] = ("gravity",)

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return with_all(_loaded_joints(robot))

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return ((-1.0, 2.0),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        who = f"the drives of all joints ({site}) add" if site == ALL_ALIKE else f"the drive of the joint {site} adds"
        return f"{who} torque of their own that cancels {100 * values['share']:.3g} % of gravity there"

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        return [(share,) for share in (1.0, 0.3, -0.3)]

    def advice(self, recordings: Sequence[Recording]) -> tuple[str, ...]:
        return (
            "Log the torque that the drives give, not what is asked of them, or switch their own gravity compensation "
            "off; what it adds can also be told to the model (MuJoCo: gravcomp).",
        )

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        (share,) = p
        return JointForce(force=-share * joint.on * joint.gravity()), state

    def mjcf_refusal(self, robot: Robot, site: str, values: Mapping[str, float]) -> str:
        own = self.sites(robot)[:-1] if site == ALL_ALIKE else (site,)
        others = [j for j, name in enumerate(robot.names("joint")) if name not in own]
        felt = [j for j in others if j not in robot.scalar_joints or not _is_still(robot, j)]
        return "MuJoCo compensates gravity at all joints that carry a body alike" if felt else ""

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        nominal = robot.model
        for index in np.flatnonzero((nominal.body_mass > 0.0) & (nominal.body_weldid != 0)).tolist():
            spec_element(spec, robot, "body", robot.names("body")[index]).gravcomp += values["share"]
        if not any(body.gravcomp > 0.0 for body in spec.bodies):  # else MuJoCo takes none into account
            name = free_name([body.name for body in spec.bodies], "weightless")
            spec.worldbody.add_body(name=name, gravcomp=1.0)


def _is_still(robot: Robot, joint: int) -> bool:
    """Whether gravity puts next to nothing on a joint."""
    return scales.gravity_torque(robot, joint) <= _FELT * scales.joint_torque(robot, joint)


@lru_cache(maxsize=64)
def _loaded_joints(robot: Robot) -> tuple[str, ...]:
    """Names of the driven joints that feel gravity."""

    def is_loaded(joint: str) -> bool:
        return not _is_still(robot, robot.index("joint", joint))

    return tuple(filter(is_loaded, driven_joint_sites(robot)))
