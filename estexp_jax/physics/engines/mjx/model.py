"""A robot on MJX: armed for the edits of a catalogue, with a solver that converges."""

from __future__ import annotations

import dataclasses
import re
import warnings
from dataclasses import dataclass
from typing import Any, final

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from mujoco import mjx

from estexp_jax.errors import InputError
from estexp_jax.physics.effects.base import NEVER, Edit
from estexp_jax.physics.effects.changes import Values
from estexp_jax.physics.effects.registry import Catalogue
from estexp_jax.physics.effects.sites import driven_actuators, joint_dofs
from estexp_jax.physics.engines.devices import exact_products
from estexp_jax.physics.engines.mjx.capabilities import reduced_to_mjx
from estexp_jax.physics.engines.mjx.polynomials import with_polynomials
from estexp_jax.physics.engines.mjx.terms import EffectForces, Hidden, MjxStepStart, apply_effects, hidden_at_rest
from estexp_jax.physics.model.derived_constants import refresh
from estexp_jax.physics.model.robot import Robot

NEWTON_ITERATIONS = 8
"""With 4 line-search steps: velocities of one step of the quadruped agree with the converged C engine to 1.1e-4 m/s
(99th percentile over 251 states under random commands, with falls), in float32; one iteration is wrong by 14 m/s."""
LINE_SEARCH_ITERATIONS = 4
_ARMED = 1e-9
"""A friction loss without effect, that makes MJX keep a row for it."""


@final
@dataclass(frozen=True, eq=False)
class MjxModel:
    """A robot's MJX model and the effects it can carry.

    Attributes:
        robot: the nominal robot.
        catalogue: the effects whose values a simulation takes.
        armed: the compiled model with the parts that the catalogue's effects need.
        model, data: the same as MJX's; templates, never changed.
    """

    robot: Robot
    catalogue: Catalogue
    armed: mujoco.MjModel
    model: mjx.Model
    data: mjx.Data

    def edited(self, model: mjx.Model, values: Values) -> mjx.Model:
        """One robot's model with its edits, and what they make stale derived anew."""
        edits = [e for e in self.catalogue if isinstance(e, Edit)]
        for effect in edits:
            model = effect.edit(self.robot, model, values[effect.name])
        return refresh(self.robot, model) if any(e.stales_inertia for e in edits) else model

    def rested(self, model: mjx.Model, values: Values, now: MjxStepStart) -> Hidden:
        """Hidden variables of a robot that has been where it is for long."""
        return hidden_at_rest(self.robot, self.catalogue, values, now, model)

    def acted(self, model: mjx.Model, values: Values, hidden: Hidden, now: MjxStepStart) -> EffectForces:
        """Forces and model of one step, from an edited model whose motors are switched."""
        model, force = with_polynomials(self.armed, model, now.qpos, now.qvel)
        does = apply_effects(self.robot, self.catalogue, model, values, hidden, now)
        return does._replace(force=does.force + force)


def mjx_model(robot: Robot, catalogue: Catalogue) -> MjxModel:
    """Put a robot on MJX.

    Raises:
        InputError: MJX cannot simulate something in the model.
    """
    exact_products()
    model = reduced_to_mjx(robot).model
    model.opt.iterations, model.opt.ls_iterations = NEWTON_ITERATIONS, LINE_SEARCH_ITERATIONS
    arms = {part for e in catalogue for part in e.arms}
    if "dof_frictionloss" in arms:
        _arm(robot, model)
    if "jnt_range" in arms:
        _arm_limits(robot, model)
    if "actuator_forcerange" in arms:
        _arm_forces(robot, model)
    try:
        if np.any(model.sensor_needstage == int(mujoco.mjtStage.mjSTAGE_ACC)) and not _rows(model):
            # Without any row, MJX's forward pass ends before the sensors of accelerations.
            model.dof_frictionloss[:] = np.maximum(model.dof_frictionloss, _ARMED)
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", 'Mesh ".*" has a coplanar face')  # slow contacts, which may be left out
            return MjxModel(robot, catalogue, model, mjx.put_model(model), mjx.make_data(model))
    except NotImplementedError as error:
        what = re.sub(r"<?mjt\w+\.(\w+)(: \d+>)?", r"\1", str(error)).translate(str.maketrans("", "", "[]()"))
        raise InputError(f"MJX cannot simulate this model: {what}", where=robot.source) from None


def _arm(robot: Robot, model: mujoco.MjModel) -> None:
    dofs = joint_dofs(robot)
    model.dof_frictionloss[dofs] = np.maximum(model.dof_frictionloss[dofs], _ARMED)


def _arm_limits(robot: Robot, model: mujoco.MjModel) -> None:
    for joint in robot.scalar_joints:
        if not model.jnt_limited[joint]:
            model.jnt_limited[joint], model.jnt_range[joint] = 1, (-NEVER, NEVER)


def _arm_forces(robot: Robot, model: mujoco.MjModel) -> None:
    for actuator in driven_actuators(robot):
        if not model.actuator_forcelimited[actuator]:
            model.actuator_forcelimited[actuator], model.actuator_forcerange[actuator] = 1, (-NEVER, NEVER)


def _rows(model: mujoco.MjModel) -> int:
    """Number of constraint rows that MJX allocates for a model."""
    impl: Any = mjx.make_data(model)._impl  # MJX's own; its C and Warp siblings have no such rows
    return impl.efc_force.size


def with_motors_switched(model: mjx.Model, enable) -> mjx.Model:  # noqa: ANN001
    """The model with motors on or off: (nu,) 1.0 or 0.0."""
    on = jnp.asarray(enable)[:, None]
    return model.replace(actuator_gainprm=model.actuator_gainprm * on, actuator_biasprm=model.actuator_biasprm * on)


def with_timestep(does: EffectForces, data: mjx.Data) -> mjx.Data:
    """One physics step, with the readings of the state it begins with.

    With RK4, MJX leaves those of the last of its four stages; the C engine, those of the first.
    """
    model = does.model
    data = data.replace(ctrl=does.ctrl, qfrc_applied=does.force, xfrc_applied=does.pull)
    after = mjx.step(model, data)
    if model.opt.integrator == mjx.IntegratorType.RK4:
        after = after.replace(sensordata=mjx.forward(model, data).sensordata)
    return after


def fields_of(model: mjx.Model) -> dict[str, jax.Array]:
    """The numeric fields of an MJX model and its options, by name."""
    found: dict[str, jax.Array] = {}
    parts: list[tuple[str, Any]] = [("", model), ("opt.", model.opt)]
    for prefix, part in parts:
        for field in dataclasses.fields(part):
            value: Any = getattr(part, field.name, None)
            if isinstance(value, jax.Array) and jnp.issubdtype(value.dtype, jnp.floating):
                found[prefix + field.name] = value
    return found
