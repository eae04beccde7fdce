"""A stop that throws the joint back, reported as a joint limit: the model's own stop hardly bounces."""

from collections.abc import Mapping
from itertools import product
from typing import ClassVar, final

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from mujoco import mjx

from estexp_jax.physics.effects.base import NEVER, Edit, Parameter
from estexp_jax.physics.effects.catalogue.joint_limit import JointLimit
from estexp_jax.physics.effects.guesses import Bounds, Vectors
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.model.robot import Robot, spec_element

_LIMIT = JointLimit()

_STIFF, _SOFT = (0.01, 500.0), (0.3, 33.0)
"""Time constant (s) and frequency (rad/s) of stops that throw a joint back at once, or after they gave way."""


@register_effect
@final
class ReboundLimit(Edit):
    """MuJoCo's joint limit with its own time constant and frequency: the less damped it swings, the more it bounces."""

    name: ClassVar[str] = "rebound_limit"
    kind: ClassVar[str] = "joint"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        *JointLimit.parameters,
        Parameter("time", "s", neutral=0.02),
        Parameter("frequency", "rad/s", neutral=50.0),
    )
    equation: ClassVar[str] = JointLimit.equation
    in_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "MuJoCo: joint/range, joint/solreflimit"
    arms: ClassVar[tuple[str, ...]] = JointLimit.arms
    flags: ClassVar[tuple[str, ...]] = JointLimit.flags
    nested_in: ClassVar[str] = "joint_limit"
    variant_of: ClassVar[str] = "joint_limit"

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return _LIMIT.sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return *_LIMIT.bounds(robot, site), (0.002, 1.0), (25.0, 3000.0)  # what is softer is no stop

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"{_LIMIT.sentence(site, values)} and bounces"

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        hard = _LIMIT.initial_guesses(robot, site, observed)
        return [(*stop, *bounce) for stop, bounce in product(hard, (_STIFF, _SOFT))]

    def from_simpler(self, simpler: Mapping[str, float], bounds: Bounds) -> Vectors:
        stop = simpler["low"], simpler["high"]
        return [(*stop, *bounce) for bounce in (*product((0.006, 0.02), (250.0, 1500.0)), _SOFT)]

    def to_simpler(self, values: Mapping[str, float]) -> Vectors:
        return [(values["low"], values["high"])]

    def reported_as(self, values: Mapping[str, float]) -> tuple[str, Mapping[str, float]]:
        return "joint_limit", {side: values[side] for side in ("low", "high")}

    def edit(self, robot: Robot, model: mjx.Model, values: jax.Array) -> mjx.Model:
        joints = np.array(robot.scalar_joints, dtype=int)
        acts = jnp.any(jnp.abs(values[:, :2]) < NEVER, axis=1)
        time, frequency = values[:, 2], values[:, 3]
        soft = jnp.stack([time, 1.0 / (time * frequency)], axis=1)  # solref holds the damping ratio
        soft = jnp.where(acts[:, None], soft, model.jnt_solref[joints])
        there = _LIMIT.edit(robot, model, values[:, :2])
        return there.replace(jnt_solref=model.jnt_solref.at[joints].set(soft))

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        _LIMIT.write_mjcf(robot, spec, site, values)
        joint = spec_element(spec, robot, "joint", site)
        joint.solref_limit = [values["time"], 1.0 / (values["time"] * values["frequency"])]
