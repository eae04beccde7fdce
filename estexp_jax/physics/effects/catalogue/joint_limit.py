"""Joint limit: a joint stops elsewhere than modelled."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from mujoco import mjx

from estexp_jax.physics.effects.base import NEVER, Edit, Parameter
from estexp_jax.physics.effects.guesses import Vectors
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import angle_unit, scalar_joint_sites
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot, spec_element


@register_effect
@final
class JointLimit(Edit):
    """low <= q <= high, as MuJoCo's joint limit; a side that is not given stays as modelled."""

    name: ClassVar[str] = "joint_limit"
    kind: ClassVar[str] = "joint"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("low", "rad", neutral=-NEVER, signed=True),
        Parameter("high", "rad", neutral=NEVER, signed=True),
    )
    equation: ClassVar[str] = "low <= q <= high"
    in_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "MuJoCo: joint/range"
    arms: ClassVar[tuple[str, ...]] = ("jnt_range",)
    flags: ClassVar[tuple[str, ...]] = ("constraint", "limit")

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return scalar_joint_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        low, high = scales.joint_span(robot, robot.index("joint", site))
        reach = 0.75 * (high - low)
        return (low, low + reach), (high - reach, high)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        sides = [f"at {values[side]:.3g} rad" for side in ("low", "high") if abs(values[side]) < NEVER]
        return f"the joint {site} stops {' and '.join(sides) or 'nowhere'}"

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        (lowest, _), (_, highest) = self.bounds(robot, site)
        low, high = observed.joint_range(robot, site)
        inside = [share * (high - low) for share in (0.05, 0.15, 0.3)]
        return [(low + x, highest) for x in inside] + [(lowest, high - x) for x in inside]

    def edit(self, robot: Robot, model: mjx.Model, values: jax.Array) -> mjx.Model:
        joints = np.array(robot.scalar_joints, dtype=int)
        limits = model.jnt_range[joints]
        return model.replace(
            jnt_range=model.jnt_range.at[joints].set(jnp.where(jnp.abs(values) < NEVER, values, limits))
        )

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        joint, nominal = spec_element(spec, robot, "joint", site), robot.model.joint(robot.index("joint", site))
        unit, given = angle_unit(robot, spec, site), (values["low"], values["high"])
        before = np.array(joint.range) * unit if nominal.limited[0] else (-NEVER, NEVER)
        joint.limited = mujoco.mjtLimited.mjLIMITED_TRUE
        joint.range = [(g if abs(g) < NEVER else b) / unit for g, b in zip(given, before, strict=True)]
