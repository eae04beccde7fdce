"""Ground friction: the floor is more or less slippery than modelled."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from mujoco import mjx

from estexp_jax.physics.effects.base import NEVER, Edit, Parameter
from estexp_jax.physics.effects.damage import Amounts, Damage, ModelError
from estexp_jax.physics.effects.guesses import Vectors
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.model.robot import Robot

_GRIPS = (0.03, 0.1, 0.25, 0.5, 0.75, 0.93, 1.07, 1.4, 2.5)
"""Shares of the modelled grip: where feet slip, a motion a little farther off is another one."""


@register_effect
@final
class GroundFriction(Edit, Damage, ModelError):
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
    amounts: ClassVar[Amounts] = Amounts(0.0, 0.95, (0.3, 0.5, 0.7, 0.85))

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return ("",) if _touches_ground(robot.model) else ()

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return ((0.02, 2.0),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"the ground's coefficient of friction is {values['mu']:.3g}"

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        [(low, high)] = self.bounds(robot, site)
        return [(min(max(share * _grip(robot), low), high),) for share in _GRIPS]

    def at_amount(self, robot: Robot, site: str, amount: float, partner: int) -> dict[str, float]:
        return {"mu": (1.0 - amount) * _grip(robot)}

    def combine(self, a: float, b: float) -> float:
        return max(a, b)

    def off_by(self, robot: Robot, site: str, error: float) -> dict[str, float]:
        return {"mu": _grip(robot) * (1.0 + abs(error))}  # of two surfaces the rougher one counts

    def edit(self, robot: Robot, model: mjx.Model, values: jax.Array) -> mjx.Model:
        mu = values[0, 0] if len(values) else jnp.asarray(NEVER)
        colliding = np.flatnonzero(_colliding(robot.model))

        def sliding(friction: jax.Array) -> jax.Array:
            return jnp.where(mu < NEVER, mu, friction)

        geoms = model.geom_friction.at[colliding, 0].set(sliding(model.geom_friction[colliding, 0]))
        pairs = model.pair_friction.at[:, :2].set(sliding(model.pair_friction[:, :2]))
        return model.replace(geom_friction=geoms, pair_friction=pairs)

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        for geom in spec.geoms:
            geom.friction = np.array([values["mu"], *geom.friction[1:]])
        for pair in spec.pairs:
            pair.friction = np.array([values["mu"], values["mu"], *pair.friction[2:]])


def _colliding(model: mujoco.MjModel) -> np.ndarray:
    """(ngeom,) bool: can touch anything."""
    return (model.geom_contype != 0) | (model.geom_conaffinity != 0)


def _touches_ground(model: mujoco.MjModel) -> bool:
    """Whether something fixed and something that moves can touch."""
    fixed = model.body_weldid[model.geom_bodyid] == 0
    return bool(np.any(_colliding(model) & fixed) and np.any(_colliding(model) & ~fixed))


def _grip(robot: Robot) -> float:
    """Largest coefficient of friction in the model."""
    return float(robot.model.geom_friction[:, 0].max())
