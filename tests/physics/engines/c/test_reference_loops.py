"""The C engine driven in four ways does one thing; its numpy networks are those of the controllers."""

import jax
import numpy as np
import pytest

from estexp_jax.physics.engines.c.reference_loops import (
    BatchedControllers,
    CRollouts,
    OpenLoopPool,
    PooledSimulator,
    SerialSimulator,
    at_rest,
)
from estexp_jax.physics.engines.controller_interface import interface_of
from estexp_jax.recovery.control.network import HIDDEN, RecurrentPolicy, decode, n_weights, respond
from tests.physics.robots import robot

STEPS, ROBOTS = 12, 3


@pytest.fixture(params=["quadruped", "cartpole"])
def course(request: pytest.FixtureRequest) -> CRollouts:
    one = robot(request.param)
    face = interface_of(one)
    weights = np.random.default_rng(0).uniform(-1.0, 1.0, (ROBOTS, n_weights(face.n_inputs, face.n_outputs)))
    return CRollouts(
        one.model, face, RecurrentPolicy(), at_rest(one.model, one.home(), face.ctrl_centre, 0.5), weights, 2
    )


def test_every_way_ends_at_the_same_place(course: CRollouts) -> None:
    pool = PooledSimulator(course)
    recorded = pool.record(ROBOTS, STEPS)
    assert recorded.shape == (ROBOTS, STEPS, course.model.nu)
    ends = SerialSimulator(course).rollout(ROBOTS, STEPS)
    assert np.ptp(ends, axis=0).max() > 1e-3
    for other in (pool, SerialSimulator(course, recorded), OpenLoopPool(course, recorded)):
        np.testing.assert_allclose(other.rollout(ROBOTS, STEPS), ends, rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(other.rollout(2, STEPS), ends[:2], rtol=0.0, atol=1e-12)


def test_networks_are_the_controllers(course: CRollouts) -> None:
    face, rng, hidden = course.face, np.random.default_rng(1), np.zeros((ROBOTS, HIDDEN))
    many, one = (BatchedControllers(course.policy, w, face) for w in (course.weights, course.weights[1]))
    for _ in range(3):
        qpos, felt = rng.normal(size=(ROBOTS, course.model.nq)), rng.normal(size=(ROBOTS, course.model.nsensordata))
        found = many.commands(qpos, felt)
        for i, weights in enumerate(course.weights):
            network = decode(jax.numpy.asarray(weights), face.n_inputs, face.n_outputs)
            readings = face.readings(jax.numpy.asarray(qpos[i]), jax.numpy.asarray(felt[i]))
            hidden[i], outputs = respond(network, jax.numpy.asarray(hidden[i]), face.inputs(readings), 3.0)
            np.testing.assert_allclose(found[i], face.commands(outputs), atol=1e-5)
        np.testing.assert_allclose(one.commands(qpos[1], felt[1]), found[1], atol=1e-12)
