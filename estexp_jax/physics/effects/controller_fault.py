"""Effects inside a robot's controller."""

from __future__ import annotations

import abc
from typing import Any

import jax

from estexp_jax.physics.effects.base import Effect
from estexp_jax.physics.model.robot import Robot


class ControllerFault(Effect):
    """Acts inside the controller: network -> network."""

    @abc.abstractmethod
    def damage(self, robot: Robot, network: Any, values: jax.Array) -> Any:
        """The network with the fault in it."""


class CommandRoute(ControllerFault):
    """Gives a motor another's command: inside the controller, and in open loop on the commands."""

    @abc.abstractmethod
    def route(self, robot: Robot, values: Any) -> Any:
        """Index of the command that each motor obeys, or -1 for its own.

        Args:
            robot: the nominal robot.
            values: (..., n_sites, n_parameters), of numpy or JAX.

        Returns:
            (..., nu).
        """
