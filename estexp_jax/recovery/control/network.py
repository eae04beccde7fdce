"""The paper's controller: a small recurrent network from readings to motor commands.

Inputs (readings scaled to [-1, 1]) and a bias feed three hidden neurons, which also see each other's last output;
they and a bias feed one output per motor. On the quadruped: 27 + 9 + 32 = 68 weights in [-1, 1].
Activation: tanh with a gain, for the "thresholding" of the text.

Source: Bongard and Lipson 2004, section 2.2 and Figure 4.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, final

import jax
import jax.numpy as jnp
import numpy as np

from estexp_jax.physics.engines.policy import HostPolicy, Policy

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


@final
@dataclass(frozen=True)
class RecurrentPolicy(Policy):
    """The paper's networks as the engines drive robots by them.

    Attributes:
        gain: of the neurons' tanh.
    """

    gain: float = 3.0

    @property
    def n_hidden(self) -> int:
        """See `Policy`."""
        return HIDDEN

    def n_weights(self, n_inputs: int, n_outputs: int) -> int:
        """See `Policy`."""
        return n_weights(n_inputs, n_outputs)

    def decode(self, weights: jax.Array, n_inputs: int, n_outputs: int) -> Network:
        """See `Policy`."""
        return decode(weights, n_inputs, n_outputs)

    def respond(self, parameters: Network, hidden: jax.Array, inputs: jax.Array) -> tuple[jax.Array, jax.Array]:
        """See `Policy`."""
        return respond(parameters, hidden, inputs, self.gain)

    def prepare_lanes(self, parameters: Network) -> Network:
        """See `Policy`; a motor that repeats another gets the other's weights."""
        return parameters._replace(w_output=parameters.w_output[parameters.output_of])

    def respond_lanes(
        self, parameters: Network, hidden: Sequence[Any], inputs: Sequence[Any]
    ) -> tuple[list[Any], list[Any]]:
        """See `Policy`."""

        def weighted(weights: Any, xs: Any) -> Any:
            return sum(weights[i] * x for i, x in enumerate(xs))

        drives = [
            parameters.w_hidden[h, len(inputs)]
            + weighted(parameters.w_hidden[h], inputs)
            + weighted(parameters.w_recurrent[h], hidden)
            for h in range(HIDDEN)
        ]
        neurons = [jnp.tanh(self.gain * d) * parameters.hidden_gain[h] for h, d in enumerate(drives)]
        outputs = [jnp.tanh(self.gain * (w[HIDDEN] + weighted(w, neurons))) for w in parameters.w_output]
        return neurons, outputs

    def on_host(self, weights: np.ndarray, n_inputs: int, n_outputs: int) -> HostPolicy:
        """See `Policy`."""
        return HostNetworks(weights, n_inputs, n_outputs, self.gain)

    def constant(self, outputs: np.ndarray, n_inputs: int) -> np.ndarray:
        """See `Policy`; only the outputs' biases differ from zero."""
        n, n_outputs = outputs.shape
        before = HIDDEN * (n_inputs + 1 + HIDDEN)
        weights = np.zeros((n, before + n_outputs * (HIDDEN + 1)), np.float32)
        limited = np.clip(outputs.astype(float), -1.0 + 1e-6, 1.0 - 1e-6)
        weights[:, before + HIDDEN :: HIDDEN + 1] = np.arctanh(limited) / self.gain
        return weights


@final
class HostNetworks(HostPolicy):
    """The networks of many robots (n, ...), or of one of them, in numpy and in double precision."""

    def __init__(self, weights: np.ndarray, n_inputs: int, n_outputs: int, gain: float) -> None:
        """For weights (n, n_weights), or (n_weights,) for one robot."""
        i, o, head = n_inputs, n_outputs, weights.shape[:-1]
        a, b = HIDDEN * (i + 1), HIDDEN * (i + 1) + HIDDEN * HIDDEN
        first = gain * weights[..., :a].reshape(*head, HIDDEN, i + 1).astype(float)
        last = gain * weights[..., b:].reshape(*head, o, HIDDEN + 1).astype(float)
        again = gain * weights[..., a:b].reshape(*head, HIDDEN, HIDDEN)
        # One product gives both: inputs and the neurons' last outputs side by side.
        self._first, self._bias = np.concatenate([first[..., :-1], again], axis=-1), first[..., -1]
        self._last, self._last_bias = last[..., :-1].copy(), last[..., -1].copy()
        self._columns = np.zeros((*head, i + HIDDEN))
        self.inputs = self._columns[..., :i]

    def respond(self) -> np.ndarray:
        """See `HostPolicy`."""
        hidden = np.tanh(np.matvec(self._first, self._columns) + self._bias)
        self._columns[..., -HIDDEN:] = hidden
        return np.tanh(np.matvec(self._last, hidden) + self._last_bias)
