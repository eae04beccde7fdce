"""The paper's controller: a small recurrent network from readings to motor commands.

Inputs (readings scaled to [-1, 1]) and a bias feed three hidden neurons, which also see each other's last output;
they and a bias feed one output per motor. On the quadruped: 27 + 9 + 32 = 68 weights in [-1, 1].
Activation: tanh with a gain, for the "thresholding" of the text.

Source: Bongard and Lipson 2004, section 2.2 and Figure 4.
"""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp

HIDDEN = 3
"""Number of hidden neurons."""


class Network(NamedTuple):
    """One controller; batched, every array has a leading axis."""

    w_hidden: jax.Array  #: (HIDDEN, n_inputs + 1) from inputs and bias
    w_recurrent: jax.Array  #: (HIDDEN, HIDDEN) from the hidden outputs of the step before
    w_output: jax.Array  #: (n_outputs, HIDDEN + 1) from hidden and bias
    hidden_gain: jax.Array  #: (HIDDEN,) 1.0 for healthy neurons
    output_of: jax.Array  #: (n_outputs,) int32, whose value each motor takes: its own index when healthy


def n_weights(n_inputs: int, n_outputs: int) -> int:
    """Length of a controller's genome."""
    return HIDDEN * (n_inputs + 1) + HIDDEN * HIDDEN + n_outputs * (HIDDEN + 1)


def decode(weights: jax.Array, n_inputs: int, n_outputs: int) -> Network:
    """The network of one genome (n_weights,)."""
    a = HIDDEN * (n_inputs + 1)
    b = a + HIDDEN * HIDDEN
    return Network(
        w_hidden=weights[:a].reshape(HIDDEN, n_inputs + 1),
        w_recurrent=weights[a:b].reshape(HIDDEN, HIDDEN),
        w_output=weights[b:].reshape(n_outputs, HIDDEN + 1),
        hidden_gain=jnp.ones(HIDDEN, weights.dtype),
        output_of=jnp.arange(n_outputs, dtype=jnp.int32),
    )


def respond(network: Network, hidden: jax.Array, inputs: jax.Array, gain: float) -> tuple[jax.Array, jax.Array]:
    """One control step: new hidden outputs (HIDDEN,) and motor outputs (n_outputs,), both in [-1, 1]."""
    ones = jnp.ones(1, inputs.dtype)
    drive = network.w_hidden @ jnp.concatenate([inputs, ones]) + network.w_recurrent @ hidden
    hidden = jnp.tanh(gain * drive) * network.hidden_gain
    outputs = jnp.tanh(gain * (network.w_output @ jnp.concatenate([hidden, ones])))
    return hidden, outputs[network.output_of]
