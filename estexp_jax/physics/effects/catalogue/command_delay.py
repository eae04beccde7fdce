"""Command delay: a motor obeys late."""

from collections.abc import Mapping
from typing import ClassVar, final

import mujoco
import numpy as np

from estexp_jax.physics.effects.base import CommandShift, Parameter
from estexp_jax.physics.effects.delays import add_delay, delay_refusal, is_longer_than_step
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import ALL_ALIKE, with_all
from estexp_jax.physics.model.robot import Robot, spec_element


@register_effect
@final
class CommandDelay(CommandShift):
    """u(t) = command(t - delay)."""

    name: ClassVar[str] = "command_delay"
    kind: ClassVar[str] = "actuator"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("delay", "s"),)
    equation: ClassVar[str] = "u(t) = command(t - delay)"
    in_mjcf: ClassVar[bool] = True
    extends_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "transport delay; MuJoCo: actuator/delay"

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return with_all(tuple(robot.names("actuator")[a] for a in _with_inputs(robot)))

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return ((0.0, 0.2),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        how = f"{1000 * values['delay']:.3g} ms late"
        return f"all motors ({site}) obey {how}" if site == ALL_ALIKE else f"the motor {site} obeys its commands {how}"

    def identifiable(self, robot: Robot, site: str, values: Mapping[str, float], observed: Observed) -> bool:
        return is_longer_than_step(robot, values["delay"])

    def mjcf_refusal(self, robot: Robot, site: str, values: Mapping[str, float]) -> str:
        return delay_refusal(robot, values["delay"])

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        for one in self.sites(robot)[:-1] if site == ALL_ALIKE else (site,):
            add_delay(spec, spec_element(spec, robot, "actuator", one), values["delay"])

    def shift(self, robot: Robot, values: np.ndarray) -> np.ndarray:
        motors = _with_inputs(robot)
        own, alike = np.split(values[..., 0], [len(motors)], axis=-1)
        each = np.maximum(own + alike.sum(axis=-1, keepdims=True), 0.0)
        return np.repeat(each, robot.model.actuator_ctrlnum[motors], axis=-1)


def _with_inputs(robot: Robot) -> np.ndarray:
    """Indices of the actuators with a command."""
    return np.flatnonzero(robot.model.actuator_ctrlnum)
