"""Engines drive robots by any policy, not only the paper's network."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from estexp_jax.physics.effects.catalogue.neuron_fault import NeuronFault
from estexp_jax.physics.effects.changes import encode, parse_change, stack
from estexp_jax.physics.effects.registry import catalogue
from estexp_jax.physics.engines.c.reference_loops import CRollouts, PooledSimulator, StartState
from estexp_jax.physics.engines.choice import closed_loop_simulator
from estexp_jax.physics.engines.policy import HostPolicy, Policy
from tests.physics.robots import robot


class Gains(NamedTuple):
    weights: Any
    hidden_gain: Any
    output_of: Any


@dataclass(frozen=True)
class Averaging(Policy):
    """Outputs are weights on a running mean of the first two inputs."""

    @property
    def n_hidden(self) -> int:
        return 2

    def n_weights(self, n_inputs: int, n_outputs: int) -> int:
        return 3 * n_outputs

    def decode(self, weights: jax.Array, n_inputs: int, n_outputs: int) -> Gains:
        return Gains(weights.reshape(n_outputs, 3), jnp.ones(2), jnp.arange(n_outputs, dtype=jnp.int32))

    def respond(self, parameters: Gains, hidden: jax.Array, inputs: jax.Array) -> tuple[jax.Array, jax.Array]:
        hidden = 0.5 * (hidden + inputs[:2]) * parameters.hidden_gain
        return hidden, (parameters.weights[:, :2] @ hidden + parameters.weights[:, 2])[parameters.output_of]

    def prepare_lanes(self, parameters: Gains) -> Gains:
        return parameters._replace(weights=parameters.weights[parameters.output_of])

    def respond_lanes(
        self, parameters: Gains, hidden: Sequence[Any], inputs: Sequence[Any]
    ) -> tuple[list[Any], list[Any]]:
        pairs = zip(hidden, inputs[:2], parameters.hidden_gain, strict=True)
        new = [0.5 * (h + u) * gain for h, u, gain in pairs]
        return new, [w[0] * new[0] + w[1] * new[1] + w[2] for w in parameters.weights]

    def on_host(self, weights: np.ndarray, n_inputs: int, n_outputs: int) -> HostPolicy:
        return OnHost(weights, n_inputs, n_outputs)

    def constant(self, outputs: np.ndarray, n_inputs: int) -> np.ndarray:
        weights = np.zeros((*outputs.shape, 3), np.float32)
        weights[..., 2] = outputs
        return weights.reshape(len(outputs), -1)


class OnHost(HostPolicy):
    def __init__(self, weights: np.ndarray, n_inputs: int, n_outputs: int) -> None:
        self._weights = weights.reshape(*weights.shape[:-1], n_outputs, 3).astype(float)
        self.inputs, self._hidden = np.zeros((*weights.shape[:-1], n_inputs)), 0.0

    def respond(self) -> np.ndarray:
        self._hidden = 0.5 * (self._hidden + self.inputs[..., :2])
        return np.matvec(self._weights[..., :2], self._hidden) + self._weights[..., 2]


@pytest.mark.parametrize("engine", ["mjx", "lanes"])
def test_any_policy_drives_robots_alike_in_every_engine(engine: str) -> None:
    one, rng, steps = robot("cartpole"), np.random.default_rng(0), 6
    simulator = closed_loop_simulator(
        one, catalogue(["body_mass"]), policy=Averaging(), rows=steps, control_step=0.01, population=8, engine=engine
    )
    assert simulator.n_weights == 3 * one.model.nu
    weights = rng.uniform(-0.3, 0.3, (3, simulator.n_weights)).astype(np.float32)
    values = stack([encode(one, simulator.catalogue, ())] * 3)
    final = simulator.rollout(values, weights, simulator.home(values), steps).final
    start = StartState(*(np.asarray(x[0], float) for x in simulator.home(values)[:4]))
    course = CRollouts(one.model, simulator.interface, Averaging(), start, weights, simulator.substeps)
    expected = PooledSimulator(course).rollout(3, steps)
    assert np.ptp(expected, axis=0).max() > 1e-4
    np.testing.assert_allclose(final.qpos, expected, atol=1e-5)


def test_a_neuron_fault_has_a_place_for_each_hidden_neuron_of_the_policy() -> None:
    one = robot("cartpole")
    simulator = closed_loop_simulator(
        one, catalogue(["neuron_fault"]), policy=Averaging(), rows=2, control_step=0.01, engine="mjx"
    )
    (fault,) = simulator.catalogue
    assert fault.sites(one) == ("hidden_0", "hidden_1")
    assert NeuronFault().sites(one) == ("hidden_0", "hidden_1", "hidden_2")
    values = stack([encode(one, simulator.catalogue, [parse_change("neuron_fault@hidden_1 gain=0.25", one)])])
    weights = np.zeros((1, simulator.n_weights), np.float32)
    damaged = simulator.controller({"neuron_fault": values["neuron_fault"][0]}, jnp.asarray(weights[0]))
    np.testing.assert_array_equal(damaged.hidden_gain, [1.0, 0.25])
