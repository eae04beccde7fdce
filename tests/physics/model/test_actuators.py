"""Actuators with several inputs or none: each array of MuJoCo's is addressed by what it counts."""

import mujoco
import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.experiment_design.excitation import excitation_range
from estexp_jax.lanes.capabilities import refusal
from estexp_jax.physics.effects.changes import encode, parse_change
from estexp_jax.physics.effects.registry import catalogue
from estexp_jax.physics.effects.sites import actuator_sites, driven_joint_sites
from estexp_jax.physics.engines.controller_interface import interface_of
from estexp_jax.physics.engines.mjx.model import mjx_model
from estexp_jax.physics.engines.open_loop_inputs import command_routes
from estexp_jax.physics.model.actuators import (
    POSITION,
    VELOCITY,
    actuator_of_input,
    affine_actuators,
    declared_inputs,
    gear_of,
    inputs_of,
    position_input,
    single_inputs,
    unusual_actuator,
)
from estexp_jax.physics.model.robot import Robot
from tests.physics.mixed_actuators import MIXED
from tests.physics.robots import robot
from tests.versions import needs_mujoco_4

pytestmark = needs_mujoco_4


@pytest.fixture(scope="module")
def mixed() -> Robot:
    return Robot.from_string(MIXED, "mixed.xml")


def test_addresses_follow_inputs_and_outputs(mixed: Robot) -> None:
    model = mixed.model
    assert mixed.names("actuator") == ("turn", "brake", "pid", "push", "servo") and (model.nu, model.nout) == (7, 7)
    assert [list(inputs_of(model, a)) for a in range(5)] == [[0, 1, 2], [], [3, 4], [5], [6]]
    assert mixed.command_columns() == ("turn.0", "turn.1", "turn.2", "pid.0", "pid.1", "push", "servo")
    assert actuator_of_input(model).tolist() == [0, 0, 0, 2, 2, 3, 4]
    assert single_inputs(model).tolist() == [3, 4] == np.flatnonzero(affine_actuators(model)).tolist()
    assert gear_of(model, 3) == 2.0 and gear_of(model, 4) == 3.0  # the orientation servo has three outputs
    assert [position_input(model, a) for a in range(5)] == [None, None, 3, None, 6]
    assert [declared_inputs(model, a) for a in (1, 2)] == [(), (POSITION, VELOCITY)]
    assert unusual_actuator(model) == (0, "3 inputs") and unusual_actuator(robot("cartpole").model) is None


def test_effects_act_where_a_motor_has_one_input_and_an_affine_force(mixed: Robot) -> None:
    assert actuator_sites(mixed) == ("push", "servo")
    assert driven_joint_sites(mixed) == ("wrist",)  # the elbow has a brake and a controller of its own, too
    effects = catalogue(["command_delay", "tied_outputs", "motor_weakness"])
    assert effects[0].sites(mixed) == ("turn", "pid", "push", "servo", "*")
    assert effects[1].sites(mixed) == ("push", "servo")
    changes = [parse_change(text, mixed) for text in ("command_delay@pid delay=0.01", "tied_outputs@push with=servo")]
    values = {name: x[None] for name, x in encode(mixed, effects, changes).items()}
    shift, source = command_routes(mixed, effects, values)
    np.testing.assert_allclose(shift[0], [0, 0, 0, 0.01, 0.01, 0, 0])
    assert source[0].tolist() == [0, 1, 2, 3, 4, 6, 6]


def test_commands_that_excite_a_robot_suit_each_input(mixed: Robot) -> None:
    centre, reach = excitation_range(mixed)
    assert centre.shape == reach.shape == (7,) and np.all(reach > 0.0)
    quaternion = Robot.from_string(MIXED.replace('kp="30" joint="neck"', 'kp="30" joint="neck" input="quat"'))
    assert excitation_range(quaternion)[0][:4].tolist() == [1.0, 0.0, 0.0, 0.0]


def test_other_engines_and_recover_refuse_them_by_name(mixed: Robot) -> None:
    assert refusal(mixed.model) == "ball joint 'neck' is not supported"
    hinged = mujoco.MjSpec.from_string(MIXED)
    for odd in (hinged.actuator("turn"), hinged.actuator("brake"), hinged.sensor("looks")):
        hinged.delete(odd)
    hinged.joint("neck").type = mujoco.mjtJoint.mjJNT_HINGE
    assert refusal(hinged.compile()) == "actuator 'pid' with several inputs or none is not supported"
    with pytest.raises(InputError, match="MJX has no actuator with 3 inputs: 'turn'; use --engine c"):
        mjx_model(mixed, ())
    with pytest.raises(InputError, match="actuator 'turn': the actuator has 3 inputs"):
        interface_of(mixed)
