"""Part lost: a joint separates, and everything below it is gone."""

from collections.abc import Mapping, Sequence
from typing import ClassVar, final

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from mujoco import mjx

from estexp_jax.physics.effects.base import Edit, Parameter
from estexp_jax.physics.effects.damage import PRESENT, Amounts, Damage
from estexp_jax.physics.effects.guesses import Vectors
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import lost_bodies
from estexp_jax.physics.model.robot import Robot, spec_element

NO_CONTACT = -1e6
"""A contact margin that no distance undercuts."""


def lost_masks(robot: Robot) -> dict[str, np.ndarray]:
    """What goes with each part that can come off: 0/1 arrays (n_sites, n) of bodies, dofs, geoms, motors, sensors."""
    model, names = robot.model, lost_bodies(robot)
    body = np.zeros((len(names), model.nbody))
    for row, name in enumerate(names):
        body[row, list(robot.subtree(robot.index("body", name)))] = 1.0
    joints = [robot.joint_of_actuator(a) for a in range(model.nactuator)]
    driven = [None if j is None else int(model.jnt_bodyid[j]) for j in joints]
    sensed = [robot.body_of_sensor(s) for s in range(model.nsensor)]
    return {
        "body": body,
        "dof": body[:, model.dof_bodyid],
        "geom": body[:, model.geom_bodyid],
        "actuator": body[:, _or_world(driven)],
        "sensor": np.repeat(body[:, _or_world(sensed)], model.sensor_dim, axis=1),
    }


def _or_world(bodies: Sequence[int | None]) -> np.ndarray:
    """Body indices; what sits on no body counts to the world, which is never lost."""
    return np.array([b or 0 for b in bodies], dtype=int)


class Loss(Edit):
    """What a body that comes off takes with it; `lost` is 0 or 1, in between is not meant."""

    kind: ClassVar[str] = "body"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("lost", ""),)
    in_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "Bongard and Lipson 2004, section 2.2"
    stales_inertia: ClassVar[bool] = True

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return lost_bodies(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return ((1.0, 1.0),)

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        return [(1.0,)]


@register_effect
@final
class PartLost(Loss, Damage):
    """No mass, no contact, no motor below the joint. The structure stays, so nothing is compiled anew.

    The lost joints keep a rotor inertia of 1 kg m2, so that the mass matrix stays regular; they pull on nothing.
    """

    name: ClassVar[str] = "part_lost"
    equation: ClassVar[str] = "the body and all below it are gone"
    removes_part: ClassVar[bool] = True
    gene: ClassVar[int | None] = 0
    amounts: ClassVar[Amounts] = PRESENT
    acts_at_zero: ClassVar[bool] = True

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"the part {site} broke off"

    def at_amount(self, robot: Robot, site: str, amount: float, partner: int) -> dict[str, float]:
        return {"lost": 1.0}

    def amount_of_gene(self, value: float) -> float:
        return 1.0

    def combine(self, a: float, b: float) -> float:
        return max(a, b)

    def edit(self, robot: Robot, model: mjx.Model, values: jax.Array) -> mjx.Model:
        gone = {
            k: jnp.clip(values[:, 0] @ jnp.asarray(m, values.dtype), 0.0, 1.0) for k, m in lost_masks(robot).items()
        }
        left = {k: 1.0 - v for k, v in gone.items()}
        return model.replace(
            body_mass=model.body_mass * left["body"],
            body_inertia=model.body_inertia * left["body"][:, None],
            dof_armature=model.dof_armature * left["dof"] + gone["dof"],
            dof_frictionloss=model.dof_frictionloss * left["dof"],
            geom_margin=jnp.where(gone["geom"] > 0.5, NO_CONTACT, model.geom_margin),
            actuator_gainprm=model.actuator_gainprm * left["actuator"][:, None],
            actuator_biasprm=model.actuator_biasprm * left["actuator"][:, None],
        )

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        spec.delete(spec_element(spec, robot, "body", site))
