"""Friction of many joints alike: one place for what a simulator lacks at each of them."""

import numpy as np
import pytest

from estexp_jax.discovery.hypotheses import claiming, parameters_only
from estexp_jax.discovery.verdict import is_wrong_value
from estexp_jax.physics.effects.changes import Change, encode
from estexp_jax.physics.effects.registry import catalogue, effect
from estexp_jax.physics.effects.sites import ALL_ALIKE, scalar_joint_sites
from estexp_jax.physics.engines.mjx.model import mjx_model
from estexp_jax.physics.model.robot import Robot

_LINK = '<body pos="0 0 0.1"><joint name="{}" type="{}" axis="0 1 0" damping="{}"/><geom size="0.02" mass="0.1"/>'
RUBS = [("viscous_friction", "c", "dof_damping"), ("coulomb_friction", "T", "dof_frictionloss")]


def chain(*kinds: str) -> Robot:
    """Links one on the other, with joints of these kinds."""
    links = "".join(_LINK.format(f"j{i}", kind, 0.1 * (i + 1)) for i, kind in enumerate(kinds))
    motors = "".join(f'<position joint="j{i}" kp="5"/>' for i in range(len(kinds)))
    return Robot.from_string(
        f"<mujoco><worldbody>{links}{'</body>' * len(kinds)}</worldbody><actuator>{motors}</actuator></mujoco>"
    )


@pytest.mark.parametrize(("name", "parameter", "field"), RUBS)
def test_all_alike_is_each_of_them(name: str, parameter: str, field: str) -> None:
    robot = chain(*["hinge"] * 4)
    on, rub = mjx_model(robot, catalogue([name])), effect(name)
    everywhere = [Change(name, ALL_ALIKE, {parameter: 0.3}), Change(name, "j2", {parameter: 0.1})]
    one_by_one = [Change(name, f"j{i}", {parameter: 0.4 if i == 2 else 0.3}) for i in range(4)]
    edited = [
        np.asarray(getattr(on.edited(on.model, encode(robot, on.catalogue, c)), field))
        for c in (everywhere, one_by_one)
    ]
    assert np.allclose(edited[0], edited[1])
    assert np.allclose(edited[0] - getattr(robot.model, field), [0.3, 0.3, 0.4, 0.3])
    spec = robot.spec.copy()
    for change in everywhere:
        rub.write_mjcf(robot, spec, change.name or "", change.values)
    assert np.allclose(getattr(spec.compile(), field), edited[0])
    assert f"every joint ({ALL_ALIKE}) resists" in rub.sentence(ALL_ALIKE, {parameter: 0.3})


@pytest.mark.parametrize("name", [name for name, *_ in RUBS])
def test_only_many_joints_of_one_kind_are_alike(name: str) -> None:
    few, mixed = chain(*["hinge"] * 3), chain("slide", *["hinge"] * 3)
    for robot in (few, mixed):
        assert effect(name).sites(robot) == scalar_joint_sites(robot)
    many = chain(*["hinge"] * 4)
    assert effect(name).sites(many) == (*scalar_joint_sites(many), ALL_ALIKE)


def test_it_may_be_claimed_beside_each_joints_own_value() -> None:
    robot = chain(*["hinge"] * 4)
    parameters = parameters_only(robot, catalogue(["viscous_friction", "body_mass"]))
    assert not any(f.site == ALL_ALIKE for f in parameters.free)
    claimed = claiming(robot, parameters, [("viscous_friction", ALL_ALIKE)])
    own = claimed.free[-1]
    assert (own.site, own.row, own.low) == (ALL_ALIKE, 4, 0.0) and own.high > 1.0
    assert len(claimed.free) == len(parameters.free) + 1
    small, large = (Change("viscous_friction", ALL_ALIKE, {"c": c}) for c in (0.02, 0.09))
    assert is_wrong_value(robot, small) and not is_wrong_value(robot, large)
