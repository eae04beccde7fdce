"""Controllers one step at a time are those of the batch."""

import jax.numpy as jnp
import numpy as np

from estexp_jax.recovery.control.network import respond
from estexp_jax.recovery.simulator import DamageSimulator


def test_a_controller_responds_as_the_simulated_ones_do(world: DamageSimulator) -> None:
    random, face = np.random.default_rng(1), world.closed_loop.interface
    controller = world.controller(random.integers(-100, 101, world.n_weights) / 100, 30)
    hidden, readings = random.uniform(-1, 1, 3), random.uniform(-1.2, 1.2, face.n_inputs)
    inputs = face.inputs(jnp.asarray(readings, jnp.float32))
    neurons, outputs = respond(controller.network(), jnp.asarray(hidden, jnp.float32), inputs, controller.gain)
    response = controller.respond(hidden, readings)
    assert np.allclose(response[0], neurons, atol=1e-5)
    assert np.allclose(response[1], face.commands(outputs), atol=1e-5)
