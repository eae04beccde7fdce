"""Neuron fault: a hidden neuron of the controller gives only a share of its output."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, final

import jax

from estexp_jax.physics.effects.base import Parameter
from estexp_jax.physics.effects.controller_fault import ControllerFault, Parameters
from estexp_jax.physics.effects.damage import Damage
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.model.robot import Robot


@register_effect
@final
@dataclass(frozen=True, eq=False)
class NeuronFault(ControllerFault, Damage):
    """output of the neuron = gain * nominal output.

    Attributes:
        n_hidden: hidden neurons of the controller; three in the paper's.
    """

    n_hidden: int = 3

    name: ClassVar[str] = "neuron_fault"
    kind: ClassVar[str] = "controller"
    side: ClassVar[str] = "command"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("gain", "", neutral=1.0),)
    equation: ClassVar[str] = "hidden = gain * hidden_nominal"
    source: ClassVar[str] = "Bongard and Lipson 2004, situation 11"

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return tuple(f"hidden_{i}" for i in range(self.n_hidden))

    def for_controller(self, n_hidden: int) -> NeuronFault:
        return self if n_hidden == self.n_hidden else NeuronFault(n_hidden)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return ((0.0, 1.0),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"the neuron {site} gives {100 * values['gain']:.3g} % of its output"

    def at_amount(self, robot: Robot, site: str, amount: float, partner: int) -> dict[str, float]:
        return {"gain": 1.0 - amount}

    def combine(self, a: float, b: float) -> float:
        return max(a, b)

    def damage(self, robot: Robot, network: Parameters, values: jax.Array) -> Parameters:
        return network._replace(hidden_gain=network.hidden_gain * values[:, 0])
