"""Tied outputs: a motor repeats the command of another."""

from collections.abc import Mapping
from typing import Any, ClassVar, final

import jax
import jax.numpy as jnp
import mujoco
import numpy as np

from estexp_jax.physics.effects.base import Parameter
from estexp_jax.physics.effects.controller_fault import CommandRoute, Parameters
from estexp_jax.physics.effects.damage import PRESENT, Amounts, Damage
from estexp_jax.physics.effects.guesses import Vectors, other_elements
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.spec_forces import tie, tie_refusal
from estexp_jax.physics.model.actuators import actuator_of_input, first_input, single_inputs, unusual_actuator
from estexp_jax.physics.model.robot import Robot


@register_effect
@final
class TiedOutputs(CommandRoute, Damage):
    """command of a motor = command of motor `with`. The value array holds `with` as 1 + its index; 0 is untied."""

    name: ClassVar[str] = "tied_outputs"
    kind: ClassVar[str] = "actuator"
    side: ClassVar[str] = "command"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("with", "1 + actuator index", refers="actuator"),)
    equation: ClassVar[str] = "command = command of `with`"
    in_mjcf: ClassVar[bool] = True
    extends_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "Bongard and Lipson 2004, situation 12"
    amounts: ClassVar[Amounts] = PRESENT

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return tuple(robot.names("actuator")[a] for a in single_inputs(robot.model))

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return ((1.0, float(robot.model.nactuator)),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"the motor {site} repeats the command of motor number {int(values['with'])}"

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        return [(other,) for other in other_elements(robot, "actuator", site) if self._is_possible(robot, other)]

    def at_amount(self, robot: Robot, site: str, amount: float, partner: int) -> dict[str, float]:
        return {"with": float(partner)}

    def combine(self, a: float, b: float) -> float:
        return max(a, b)

    def damage(self, robot: Robot, network: Parameters, values: jax.Array) -> Parameters:
        source = self.route(robot, values)
        return network._replace(output_of=jnp.where(source >= 0, source, network.output_of))

    def route(self, robot: Robot, values: Any) -> Any:
        other, model = values[..., 0].astype(int) - 1, robot.model
        if unusual_actuator(model) is None:
            return other
        own, owners = single_inputs(model), actuator_of_input(model)
        source = np.where(other >= 0, first_input(model)[other], -1)
        row = np.clip(np.searchsorted(own, owners), 0, max(len(own) - 1, 0))
        return np.where(np.isin(owners, own), source[..., row] if len(own) else -1, -1)

    def mjcf_refusal(self, robot: Robot, site: str, values: Mapping[str, float]) -> str:
        return tie_refusal(robot, robot.index("actuator", site), int(values["with"]) - 1)

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        tie(robot, spec, robot.index("actuator", site), int(values["with"]) - 1)

    def _is_possible(self, robot: Robot, other: float) -> bool:
        return int(other) - 1 in single_inputs(robot.model)
