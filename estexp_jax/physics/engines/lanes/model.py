"""A robot in lanes: its plan, and which numbers the edits of its catalogue make different from robot to robot."""

from __future__ import annotations

import dataclasses
from functools import cached_property
from typing import final

import jax
import jax.numpy as jnp
from mujoco import mjx

from estexp_jax.lanes.capabilities import refusal
from estexp_jax.lanes.layout import Layout, layout_of
from estexp_jax.physics.effects.changes import Values, neutral
from estexp_jax.physics.engines.mjx.model import MjxModel, fields_of

FIELDS = frozenset(
    (
        *("body_mass", "body_inertia", "body_ipos", "body_iquat", "body_pos", "body_quat", "body_invweight0"),
        *("dof_armature", "dof_damping", "dof_frictionloss", "dof_invweight0", "qpos0", "qpos_spring"),
        *("jnt_axis", "jnt_pos", "jnt_range", "jnt_solref", "jnt_margin", "jnt_stiffness", "jnt_actfrcrange"),
        *("geom_pos", "geom_quat", "geom_size", "geom_margin", "geom_friction", "site_pos", "site_quat"),
        *("actuator_gear", "actuator_gainprm", "actuator_biasprm", "actuator_ctrlrange", "actuator_forcerange"),
        "opt.gravity",
    )
)
"""Fields of a model that lanes take from robot to robot."""
_SHARED = frozenset(
    (
        *("geom_solref", "geom_solimp", "geom_solmix", "jnt_solimp", "dof_solref", "dof_solimp"),
        *("opt.impratio", "sensor_cutoff"),
    )
)
"""Fields that lanes take to be the same for all robots."""
_UNREAD = frozenset(("body_subtreemass", "actuator_acc0"))
"""Fields that edits may write and lanes have no use for."""


@final
@dataclasses.dataclass(frozen=True, eq=False)
class LanesModel:
    """A robot and the effects it can carry, for lanes.

    Attributes:
        on_mjx: the same for MJX, from where the edits come.
        written: fields that differ from robot to robot.
    """

    on_mjx: MjxModel
    written: tuple[str, ...]

    @cached_property
    def layout(self) -> Layout:
        """The structure."""
        return layout_of(self.on_mjx.armed)

    def fields(self, model: mjx.Model, values: Values) -> dict[str, jax.Array]:
        """One robot's numbers that differ from robot to robot; batched outside, robots last."""
        edited = self.on_mjx.edited(model, values)
        return {name: field_of(edited, name) for name in self.written}


def lanes_refusal(on_mjx: MjxModel, overridden: frozenset[str] = frozenset()) -> str | None:
    """Why lanes cannot simulate a robot with the effects of a catalogue; None where they can.

    Args:
        on_mjx: the robot and its catalogue.
        overridden: fields that recordings' known settings change.
    """
    refused = refusal(on_mjx.armed)
    if refused is None:
        strange = sorted((edited_fields(on_mjx) - FIELDS) | (overridden & _SHARED))
        refused = f"{strange[0]} that differs from robot to robot is not supported" if strange else None
    return refused


def lanes_model(on_mjx: MjxModel, overridden: frozenset[str] = frozenset()) -> LanesModel:
    """Put a robot into lanes that `lanes_refusal` finds nothing against.

    Args:
        on_mjx: the robot and its catalogue.
        overridden: fields that differ from robot to robot for other reasons than edits.
    """
    return LanesModel(on_mjx, tuple(sorted(edited_fields(on_mjx) | (overridden & FIELDS))))


def edited_fields(on_mjx: MjxModel) -> set[str]:
    """Names of the fields of a model that depend on the values of its edits."""
    names: list[str] = []

    def edited(values: Values) -> list[jax.Array]:
        found = fields_of(on_mjx.edited(on_mjx.model, values))
        names.extend(found)
        return list(found.values())

    values = jax.tree.map(jnp.asarray, neutral(on_mjx.robot, on_mjx.catalogue))
    program = jax.make_jaxpr(edited)(values).jaxpr
    reached = set(program.invars)
    for equation in program.eqns:
        if any(not hasattr(v, "val") and v in reached for v in equation.invars):
            reached.update(equation.outvars)
    depends = [not hasattr(v, "val") and v in reached for v in program.outvars]
    return {name for name, yes in zip(names, depends, strict=True) if yes} - _UNREAD


def field_of(model: mjx.Model, name: str) -> jax.Array:
    """A field of an MJX model or its options."""
    return getattr(model.opt, name.removeprefix("opt.")) if name.startswith("opt.") else getattr(model, name)
