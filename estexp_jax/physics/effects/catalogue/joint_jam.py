"""Joint jam: a joint moves ever harder, up to not at all."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from mujoco import mjx

from estexp_jax.physics.effects.base import Edit, Parameter
from estexp_jax.physics.effects.sites import joint_dofs, scalar_joint_sites
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot, spec_element

_STUCK_SPEED = np.deg2rad(1.0)


def jam_damping(robot: Robot, site: str, f: float) -> float:
    """Damping added by a jam of degree f: geometric, from nominal to 'full torque moves it 1 degree a second'."""
    joint = robot.index("joint", site)
    start, full = _range(robot, joint)
    return (start * (full / start) ** f - start) if f > 0.0 else 0.0


def _range(robot: Robot, joint: int) -> tuple[float, float]:
    """Damping at f = 0, the nominal one (or a small one, where there is none), and at f = 1, stuck."""
    nominal = float(robot.model.dof_damping[robot.model.jnt_dofadr[joint]])
    full = scales.joint_torque(robot, joint) / _STUCK_SPEED
    return (nominal, max(full, nominal)) if nominal > 0.0 else (1e-4 * full, full)


@final
class JointJam(Edit):
    """tau = -c(f) w with c growing geometrically from the joint's damping (f = 0) to stuck (f = 1)."""

    name: ClassVar[str] = "joint_jam"
    kind: ClassVar[str] = "joint"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("f", ""),)
    equation: ClassVar[str] = "tau = -c0 (c1 / c0)^f w"
    in_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "Bongard and Lipson 2004, section 2.2"
    flags: ClassVar[tuple[str, ...]] = ("damper",)

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return scalar_joint_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return ((0.0, 1.0),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"the joint {site} is jammed by {100 * values['f']:.3g} %"

    def edit(self, robot: Robot, model: mjx.Model, values: jax.Array) -> mjx.Model:
        start, full = np.array([_range(robot, joint) for joint in robot.scalar_joints]).reshape(-1, 2).T
        added = start * jnp.expm1(jnp.maximum(values[:, 0], 0.0) * np.log(full / start))
        return model.replace(dof_damping=model.dof_damping.at[joint_dofs(robot)].add(added))

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        joint = spec_element(spec, robot, "joint", site)
        joint.damping = [joint.damping[0] + jam_damping(robot, site, values["f"]), *joint.damping[1:]]
