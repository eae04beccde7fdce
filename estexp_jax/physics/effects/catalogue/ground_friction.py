"""Ground friction: the floor is more or less slippery than modelled."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from mujoco import mjx

from estexp_jax.physics.effects.base import NEVER, Edit, Parameter
from estexp_jax.physics.model.robot import Robot


@final
class GroundFriction(Edit):
    """|tangential force| <= mu |normal force| at every contact: sliding friction of all that touches.

    MuJoCo takes the larger friction of two geoms, so both sides are set.
    """

    name: ClassVar[str] = "ground_friction"
    kind: ClassVar[str] = "environment"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("mu", "", neutral=NEVER),)
    equation: ClassVar[str] = "|F_t| <= mu F_n"
    in_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "MuJoCo: geom/friction"
    flags: ClassVar[tuple[str, ...]] = ("constraint", "contact")

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return ("",) if _touches_ground(robot.model) else ()

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return ((0.02, 2.0),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"the ground's coefficient of friction is {values['mu']:.3g}"

    def edit(self, robot: Robot, model: mjx.Model, values: jax.Array) -> mjx.Model:
        mu = values[0, 0] if len(values) else jnp.asarray(NEVER)
        touching = np.flatnonzero(_touching(robot.model))

        def sliding(friction: jax.Array) -> jax.Array:
            return jnp.where(mu < NEVER, mu, friction)

        geoms = model.geom_friction.at[touching, 0].set(sliding(model.geom_friction[touching, 0]))
        pairs = model.pair_friction.at[:, :2].set(sliding(model.pair_friction[:, :2]))
        return model.replace(geom_friction=geoms, pair_friction=pairs)

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        for geom in spec.geoms:
            geom.friction = np.array([values["mu"], *geom.friction[1:]])
        for pair in spec.pairs:
            pair.friction = np.array([values["mu"], values["mu"], *pair.friction[2:]])


def _touching(model: mujoco.MjModel) -> np.ndarray:
    """(ngeom,) bool: can touch anything."""
    return (model.geom_contype != 0) | (model.geom_conaffinity != 0)


def _touches_ground(model: mujoco.MjModel) -> bool:
    """Whether something fixed and something that moves can touch."""
    fixed = model.body_weldid[model.geom_bodyid] == 0
    return bool(np.any(_touching(model) & fixed) and np.any(_touching(model) & ~fixed))
