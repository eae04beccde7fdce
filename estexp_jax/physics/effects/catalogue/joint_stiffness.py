"""Joint stiffness: a spring pulls a joint to some position."""

from collections.abc import Mapping
from itertools import product
from typing import ClassVar, final

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from mujoco import mjx

from estexp_jax.physics.effects.base import Array, Edit, Parameter
from estexp_jax.physics.effects.guesses import SHARES, Vectors
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.passive import add_spring
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import scalar_joint_sites
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot


@register_effect
@final
class JointStiffness(Edit):
    """tau = -k (q - q0), beside the joint's own spring: the two together are one spring, at a position between."""

    name: ClassVar[str] = "joint_stiffness"
    kind: ClassVar[str] = "joint"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("k", "N m/rad"),
        Parameter("q0", "rad", signed=True),
    )
    equation: ClassVar[str] = "tau = -k (q - q0)"
    in_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "MuJoCo: joint/stiffness, joint/springref"
    additive: ClassVar[bool] = True
    flags: ClassVar[tuple[str, ...]] = ("spring",)
    nested_in: ClassVar[str] = "torque_offset"
    beside_laws: ClassVar[bool] = True

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return scalar_joint_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        joint = robot.index("joint", site)
        low, high = scales.joint_span(robot, joint)
        return (0.0, 4.0 * np.pi * scales.joint_torque(robot, joint) / (high - low)), (low, high)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"a spring of {values['k']:.3g} N m/rad pulls the joint {site} towards {values['q0']:.3g} rad"

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        low, high = observed.joint_range(robot, site)
        most = self.bounds(robot, site)[0][1]
        return [(s * most, q) for s, q in product(SHARES, (low, 0.5 * (low + high), high))]

    def to_simpler(self, values: Mapping[str, float]) -> Vectors:
        return [(values["k"] * values["q0"],)]

    def edit(self, robot: Robot, model: mjx.Model, values: jax.Array) -> mjx.Model:
        joints = np.array(robot.scalar_joints, dtype=int)
        places = robot.model.jnt_qposadr[joints]
        k, rest = _together(model.jnt_stiffness[joints], model.qpos_spring[places], values[:, 0], values[:, 1])
        return model.replace(
            jnt_stiffness=model.jnt_stiffness.at[joints].set(k), qpos_spring=model.qpos_spring.at[places].set(rest)
        )

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        add_spring(robot, spec, site, (values["k"], 0.0, 0.0), values["q0"])


def _together(k: Array, rest: Array, more: Array, other: Array) -> tuple[Array, Array]:
    """Stiffness and rest position of two springs side by side; unchanged where there is no more."""
    total = k + more
    between = (k * rest + more * other) / jnp.where(total > 0.0, total, 1.0)
    return total, jnp.where(more > 0.0, between, rest)
