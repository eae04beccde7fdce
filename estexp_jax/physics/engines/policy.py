"""Controllers as engines use them, whatever their equations.

The engines own the loop of sensors, controller, motors and physics; a `Policy` owns the controller's equations. Its
parameters are a pytree with the two fields in which faults act, see `effects.controller_fault.FaultyParameters`.
"""

from __future__ import annotations

import abc
from collections.abc import Sequence
from typing import Any

import jax
import numpy as np


class HostPolicy(abc.ABC):
    """Healthy controllers of one robot or of many in numpy, for MuJoCo's C engine.

    Attributes:
        inputs: (..., n_inputs) of the next step, each in [-1, 1]; the engine writes them here.
    """

    inputs: np.ndarray

    @abc.abstractmethod
    def respond(self) -> np.ndarray:
        """Take one control step: outputs (..., n_outputs) in [-1, 1] for `inputs`."""


class Policy(abc.ABC):
    """Controllers from readings to motor outputs, each with parameters and a hidden state of its own."""

    @property
    @abc.abstractmethod
    def n_hidden(self) -> int:
        """Length of the hidden state, at least 1; it is zero before the first step."""

    @abc.abstractmethod
    def n_weights(self, n_inputs: int, n_outputs: int) -> int:
        """Number of weights of one controller."""

    @abc.abstractmethod
    def decode(self, weights: jax.Array, n_inputs: int, n_outputs: int) -> Any:
        """The parameters, a pytree, of one healthy controller with weights (n_weights,)."""

    @abc.abstractmethod
    def respond(self, parameters: Any, hidden: jax.Array, inputs: jax.Array) -> tuple[jax.Array, jax.Array]:
        """One control step of one robot.

        Args:
            parameters: as `decode` gives them, faults in them.
            hidden: (n_hidden,) of the step before.
            inputs: (n_inputs,) in [-1, 1].

        Returns:
            The new hidden state (n_hidden,), and motor outputs (n_outputs,) in [-1, 1].
        """

    @abc.abstractmethod
    def prepare_lanes(self, parameters: Any) -> Any:
        """The parameters of one robot as `respond_lanes` takes them: what need not be done anew each step is done."""

    @abc.abstractmethod
    def respond_lanes(
        self, parameters: Any, hidden: Sequence[Any], inputs: Sequence[Any]
    ) -> tuple[list[Any], list[Any]]:
        """`respond` for N robots at once.

        Args:
            parameters: as `prepare_lanes` gives them, the robots as last axis of each array.
            hidden: one array (N,) for each of the hidden state's values.
            inputs: one array (N,) for each input.

        Returns:
            New hidden state and outputs, one array (N,) for each value.
        """

    @abc.abstractmethod
    def on_host(self, weights: np.ndarray, n_inputs: int, n_outputs: int) -> HostPolicy:
        """Healthy controllers in numpy, for weights (..., n_weights)."""

    @abc.abstractmethod
    def constant(self, outputs: np.ndarray, n_inputs: int) -> np.ndarray:
        """Weights (n, n_weights), float32, of controllers that give outputs (n, n_outputs) whatever they read."""
