"""The paper's network against its twin in numpy."""

import jax
import jax.numpy as jnp
import numpy as np

from estexp_jax.physics.engines.controller_interface import interface_of
from estexp_jax.recovery.control.network import HIDDEN, RecurrentPolicy, decode, n_weights, respond
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


def test_the_policy_gives_each_engine_the_same_network() -> None:
    rng, policy, n = np.random.default_rng(1), RecurrentPolicy(GAIN), 4
    weights = rng.uniform(-1.0, 1.0, (n, policy.n_weights(N_INPUTS, N_MOTORS))).astype(np.float32)
    networks = jax.vmap(lambda w: policy.decode(w, N_INPUTS, N_MOTORS))(weights)
    tied = networks._replace(output_of=networks.output_of.at[:, 0].set(3))
    last = jax.tree.map(lambda x: jnp.moveaxis(x, 0, -1), jax.vmap(policy.prepare_lanes)(tied))
    host, hidden = policy.on_host(weights, N_INPUTS, N_MOTORS), jnp.zeros((n, HIDDEN))
    for _ in range(3):
        inputs = rng.uniform(-1.0, 1.0, (n, N_INPUTS)).astype(np.float32)
        neurons, in_lanes = policy.respond_lanes(last, tuple(hidden.T), tuple(inputs.T))
        hidden, outputs = jax.vmap(policy.respond)(tied, hidden, jnp.asarray(inputs))
        host.inputs[:] = inputs
        healthy = host.respond()
        np.testing.assert_allclose(np.array(neurons).T, hidden, atol=1e-6)
        np.testing.assert_allclose(np.array(in_lanes).T, outputs, atol=1e-6)
        np.testing.assert_allclose(healthy[:, 1:], outputs[:, 1:], atol=1e-5)
        np.testing.assert_allclose(healthy[:, 3], outputs[:, 0], atol=1e-5)


def test_weights_of_constant_outputs_give_them_whatever_is_read() -> None:
    rng, policy = np.random.default_rng(2), RecurrentPolicy(GAIN)
    wanted = rng.uniform(-1.0, 1.0, (3, N_MOTORS)).astype(np.float32)
    weights = policy.constant(wanted, N_INPUTS)
    host = policy.on_host(weights, N_INPUTS, N_MOTORS)
    for _ in range(2):
        host.inputs[:] = rng.uniform(-1.0, 1.0, host.inputs.shape)
        np.testing.assert_allclose(host.respond(), wanted, atol=1e-5)
