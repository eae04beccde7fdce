"""Joint offset: a joint's zero lies elsewhere than modelled."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax
import mujoco
import numpy as np
from mujoco import mjx

from estexp_jax.physics.effects.base import Edit, Parameter
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import angle_unit, is_slide, scalar_joint_sites
from estexp_jax.physics.model.robot import Robot, spec_element


@register_effect
@final
class JointOffset(Edit):
    """The robot is in the model's zero posture where the joint shows q = offset: the pose is that of q - offset."""

    name: ClassVar[str] = "joint_offset"
    kind: ClassVar[str] = "joint"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("offset", "rad", signed=True),)
    equation: ClassVar[str] = "pose = pose_nominal(q - offset)"
    in_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "MuJoCo: joint/ref"
    moves_zero: ClassVar[bool] = True

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return scalar_joint_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        most = 0.05 if is_slide(robot, site) else 0.5
        return ((-most, most),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"the joint {site} shows {values['offset']:+.3g} rad where the model has it at zero"

    def edit(self, robot: Robot, model: mjx.Model, values: jax.Array) -> mjx.Model:
        places = robot.model.jnt_qposadr[np.array(robot.scalar_joints, dtype=int)]
        return model.replace(qpos0=model.qpos0.at[places].add(values[:, 0]))

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        joint, unit = spec_element(spec, robot, "joint", site), angle_unit(robot, spec, site)
        joint.ref += values["offset"] / unit
