"""Parameters, windows, simulated responses and lacking torques, on an arm whose truth is known."""

import numpy as np
import pytest

from estexp_jax.estimation.channels import channels_of
from estexp_jax.estimation.dataset import Dataset, dataset_of, evenly
from estexp_jax.estimation.objective import Objective
from estexp_jax.estimation.parameters import nuisances, parameter_space, with_values
from estexp_jax.estimation.torque_balance import torque_balance
from estexp_jax.physics.effects.registry import catalogue
from estexp_jax.physics.engines.choice import open_loop_simulator
from tests.discovery.joint.arm import PLANTED, case

_EFFECTS = ("viscous_friction", "coulomb_friction", "torque_offset", "armature", "body_mass", "motor_weakness")


@pytest.fixture(scope="module")
def objective() -> Objective:
    arm = case(planted=True)
    effects = catalogue(_EFFECTS)
    simulator = open_loop_simulator(arm.robot, effects, arm.robots, engine="c")
    data = dataset_of(arm.robots, arm.recordings, channels_of(arm.robot, arm.recordings), 0.05, memory=0.1)
    return Objective(simulator, parameter_space(arm.robot, effects), evenly(data, 60), states=True)


def test_the_nominal_robot_is_neutral_and_a_point_says_what_differs(objective: Objective):
    space = objective.space
    assert not space.changes(space.neutral)
    point = with_values(space, space.neutral, ("viscous_friction", "j1"), [0.4])
    [change] = space.changes(point)
    assert (change.place, dict(change.parameters)) == ("viscous_friction@j1", {"c": pytest.approx(0.4)})
    assert space.values(point[None])["viscous_friction"][0, 0, 0] == pytest.approx(0.4)


def test_values_of_the_model_are_nuisances_unless_a_recording_gives_them(objective: Objective):
    space = objective.space
    places = {space.parameters[i].place for i in nuisances(space)}
    assert {("body_mass", "l2"), ("armature", "j4"), ("motor_weakness", "m1")} <= places
    assert ("viscous_friction", "j1") not in places  # the model has none
    assert ("body_mass", "l2") not in {space.parameters[i].place for i in nuisances(space, {("body_mass", "l2")})}


def test_windows_are_those_of_one_role_and_evenly_chosen(objective: Objective):
    data: Dataset = objective.dataset
    assert len(data.windows) == 60 and set(data.owner) == {0, 1}
    assert all(w.memory == 10 for w in data.windows)
    assert data.measurements.shape == (60, max(w.rows for w in data.windows), 4)


def test_responses_are_differences_of_simulations(objective: Objective):
    space, few = objective.space, objective.with_dataset(objective.dataset.subset(range(3)), states=True)
    direction = with_values(space, space.neutral, ("coulomb_friction", "j2"), [1.0]) - space.neutral
    found = few.responses(space.neutral, direction[None])
    apart = few.simulate(np.array([space.neutral, space.neutral + direction]))
    assert np.allclose(found.point, apart[0], equal_nan=True)
    assert np.allclose(found.change[0], apart[1] - apart[0], equal_nan=True)
    assert found.initial_state.shape[0] == 2 * 4 and np.nanmax(np.abs(found.initial_state)) > 0.0


def test_lacking_torques_are_those_that_were_left_out(objective: Objective):
    """Friction that the model lacks is the torque that balances: of its size, against the motion."""
    space = objective.space
    found = torque_balance(objective, space.neutral, np.zeros((0, len(space.neutral))), case(planted=True).robots)
    speed = np.array([w.start.qvel for w in objective.dataset.windows])
    fast = np.abs(speed) > 0.3
    missing = -np.array(PLANTED["dof_damping"]) * speed - np.array(PLANTED["dof_frictionloss"]) * np.sign(speed)
    for joint in range(4):
        left = (found.lacking - missing)[fast[:, joint], joint]
        assert np.sqrt(np.mean(left**2)) < 0.25 * np.sqrt(np.mean(missing[fast[:, joint], joint] ** 2))
