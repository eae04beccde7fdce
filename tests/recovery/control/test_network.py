"""The paper's network against its twin in numpy."""

import jax.numpy as jnp
import numpy as np

from estexp_jax.physics.engines.controller_interface import interface_of
from estexp_jax.recovery.control.network import HIDDEN, decode, n_weights, respond
from tests.physics.robots import robot
from tests.recovery.control.controller_twin import GAIN, N_INPUTS, N_MOTORS, N_WEIGHTS, Twin


def test_the_paper_has_68_synapses() -> None:
    assert n_weights(8, 8) == N_WEIGHTS == 68


def test_it_responds_as_its_twin_does() -> None:
    rng, face = np.random.default_rng(0), interface_of(robot("quadruped"))
    weights = rng.uniform(-1.0, 1.0, N_WEIGHTS)
    network, twin, hidden = (
        decode(jnp.asarray(weights, jnp.float32), N_INPUTS, N_MOTORS),
        Twin(weights),
        jnp.zeros(HIDDEN),
    )
    for _ in range(5):
        readings = np.concatenate([rng.choice([-1.0, 1.0], 4), rng.uniform(-1.0, 1.0, 4)])
        hidden, outputs = respond(network, hidden, face.inputs(jnp.asarray(readings, jnp.float32)), GAIN)
        np.testing.assert_allclose(face.commands(outputs), twin.respond(readings), atol=1e-5)
