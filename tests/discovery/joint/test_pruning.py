"""A value of the model that may be as the model has it is no finding; what the model leaves at nothing may be one."""

from types import SimpleNamespace
from typing import cast

import numpy as np

from estexp_jax.discovery.joint.criteria import SelectionCriteria
from estexp_jax.discovery.joint.growth import Growth
from estexp_jax.discovery.joint.pruning import _as_modelled
from estexp_jax.discovery.joint.reading_stage import JointFit
from estexp_jax.estimation.parameters import parameter_space
from estexp_jax.physics.effects.registry import catalogue
from estexp_jax.physics.model.robot import Robot

_ROBOT = Robot.from_string(
    '<mujoco><worldbody><body><joint name="a" armature="0.02"/><joint name="b" axis="1 0 0"/><geom size=".1"/>'
    "</body></worldbody></mujoco>"
)
_PLACES = (("armature", "a"), ("armature", "b"))


def _fit(amount: float, std: float) -> tuple[Growth, JointFit]:
    space = parameter_space(_ROBOT, catalogue(["armature"]))
    indices = np.array([int(space.of_place[p][0]) for p in _PLACES])
    point = space.neutral.copy()
    point[indices] += amount
    growth = SimpleNamespace(objective=SimpleNamespace(space=space), criteria=SelectionCriteria())
    fit = SimpleNamespace(point=point, places=_PLACES, indices=indices, std=np.full(2, std))
    return cast(Growth, growth), cast(JointFit, fit)


def test_stretches_that_disagree_on_a_value_of_the_model_leave_it_as_it_is() -> None:
    assert _as_modelled(*_fit(0.01, 0.02)) == [("armature", "a")]


def test_a_value_that_is_surely_off_stays_on_either_side() -> None:
    assert _as_modelled(*_fit(0.01, 0.005)) == []
    assert _as_modelled(*_fit(-0.01, 0.005)) == []
