"""A part lost but for a stub, reported as a part lost: the motor goes on turning what is left at its joint."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax
import jax.numpy as jnp
import mujoco
from mujoco import mjx

from estexp_jax.physics.effects.catalogue.part_lost import NO_CONTACT, Loss, lost_masks
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.model.robot import Robot, spec_element
from estexp_jax.physics.model.spec import set_masses

_STUB = 0.01
"""Share of masses and inertias that remains."""


@register_effect
@final
class PartStub(Loss):
    """Next to no mass and no contact below the joint, while its motor and its sensors work on."""

    name: ClassVar[str] = "part_stub"
    equation: ClassVar[str] = "the body and all below it are gone but for a stub"
    variant_of: ClassVar[str] = "part_lost"

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"the part {site} broke off but for a stub that its motor turns"

    def reported_as(self, values: Mapping[str, float]) -> tuple[str, Mapping[str, float]]:
        return "part_lost", dict(values)

    def edit(self, robot: Robot, model: mjx.Model, values: jax.Array) -> mjx.Model:
        masks = lost_masks(robot)
        gone = {k: jnp.clip(values[:, 0] @ jnp.asarray(masks[k], values.dtype), 0.0, 1.0) for k in ("body", "geom")}
        left = 1.0 - (1.0 - _STUB) * gone["body"]
        return model.replace(
            body_mass=model.body_mass * left,
            body_inertia=model.body_inertia * left[:, None],
            geom_margin=jnp.where(gone["geom"] > 0.5, NO_CONTACT, model.geom_margin),
        )

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        for index in robot.subtree(robot.index("body", site)):
            body = spec_element(spec, robot, "body", robot.names("body")[index])
            if robot.model.body_mass[index] > 0.0:
                set_masses(body, robot.model, index, _STUB * float(robot.model.body_mass[index]))
            for geom in body.geoms:
                geom.contype = geom.conaffinity = 0
