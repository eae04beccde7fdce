"""Effects inside a robot's controller."""

from __future__ import annotations

import abc
from typing import Any, Protocol, Self, TypeVar

import jax

from estexp_jax.physics.effects.base import Effect
from estexp_jax.physics.model.robot import Robot


class FaultyParameters(Protocol):
    """What faults may rely on in a controller's parameters, a named tuple: where they act."""

    @property
    def hidden_gain(self) -> jax.Array:
        """(n_hidden,) by what each hidden neuron's output is multiplied; 1.0 when healthy."""
        ...

    @property
    def output_of(self) -> jax.Array:
        """(n_outputs,) int32, whose output each motor takes; its own index when healthy."""
        ...

    def _replace(self, **fields: Any) -> Self: ...


Parameters = TypeVar("Parameters", bound=FaultyParameters)


class ControllerFault(Effect):
    """Acts inside the controller: parameters -> parameters."""

    def for_controller(self, n_hidden: int) -> ControllerFault:
        """The same fault for controllers with so many hidden neurons."""
        return self

    @abc.abstractmethod
    def damage(self, robot: Robot, network: Parameters, values: jax.Array) -> Parameters:
        """The controller's parameters with the fault in them.

        Args:
            robot: the nominal robot.
            network: parameters of one controller.
            values: (n_sites, n_parameters).
        """


class CommandRoute(ControllerFault):
    """Gives a motor another's command: inside the controller, and in open loop on the commands."""

    @abc.abstractmethod
    def route(self, robot: Robot, values: Any) -> Any:
        """Address of the command that stands in each command's place, or -1 for its own.

        Args:
            robot: the nominal robot.
            values: (..., n_sites, n_parameters), of numpy or JAX.

        Returns:
            (..., nu).
        """
