"""The judge of engines: right ones pass, with edits as well; a wrong one does not."""

import numpy as np
import pytest

from estexp_jax.physics.effects.changes import parse_change
from estexp_jax.physics.effects.registry import catalogue
from estexp_jax.physics.engines.choice import closed_loop_simulator
from estexp_jax.physics.engines.closed_loop_agreement import (
    closed_loop_agreement,
    engine_agreement,
    engine_speeds,
    referee_speeds,
    sample_states,
)
from estexp_jax.physics.engines.controller_interface import interface_of
from estexp_jax.recovery.control.network import RecurrentPolicy
from tests.physics.robots import robot

CHANGES = [(), ("body_mass@pole dm=0.1", "joint_jam@swing f=0.4", "motor_weakness@push loss=0.3")]
SETS = [[parse_change(text, robot("cartpole")) for text in texts] for texts in CHANGES]


@pytest.mark.parametrize("engine", ["mjx", "lanes"])
def test_engines_agree_and_a_wrong_one_does_not(engine: str) -> None:
    one = robot("cartpole")
    effects = catalogue(["body_mass", "motor_weakness", "joint_jam"])
    simulator = closed_loop_simulator(
        one, effects, policy=RecurrentPolicy(), rows=12, control_step=0.01, population=4, engine=engine
    )  # as in test_closed_loop.py, so that it is compiled once
    states = sample_states(one, simulator.interface, 40)
    found = closed_loop_agreement(simulator, states, SETS)
    assert found.agrees and found.states == 40 and found.physics_steps == 2
    assert found.median <= found.high <= found.largest
    assert "agrees with plain MuJoCo" in found.sentence()
    # The edits are not where the referee has them: every other state is off.
    speeds = engine_speeds(simulator, states, SETS)
    assert not engine_agreement(speeds, referee_speeds(one, simulator.interface, states, 2), 2).agrees


def test_states_are_visited_ones_and_the_same_for_one_seed() -> None:
    quadruped = robot("quadruped")
    face = interface_of(quadruped)
    states, again, other = (sample_states(quadruped, face, 20, seed) for seed in (0, 0, 1))
    np.testing.assert_array_equal(states.qpos, again.qpos)
    assert not np.array_equal(states.qpos, other.qpos)
    assert np.abs(states.qvel).max() > 1.0 and np.abs(states.outputs).max() <= 1.0


def test_what_is_not_finite_does_not_agree() -> None:
    expected = np.ones((10, 3))
    assert engine_agreement(expected + 1e-6, expected, 1).agrees
    for wrong in (np.nan, np.inf):
        found = expected.copy()
        found[:, 1] = wrong
        assert not engine_agreement(found, expected, 1).agrees


def test_an_effect_without_a_place_in_mjcf_is_refused() -> None:
    one = robot("quadruped")
    face = interface_of(one)
    with pytest.raises(ValueError, match="neuron_fault"):
        fault = parse_change("neuron_fault@hidden_0 gain=0", one)
        referee_speeds(one, face, sample_states(one, face, 1), 1, [[fault]])
