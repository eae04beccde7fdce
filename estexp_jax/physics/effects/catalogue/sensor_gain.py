"""Sensor gain: a reading is scaled."""

from collections.abc import Mapping
from typing import Any, ClassVar, final

import jax
import numpy as np

from estexp_jax.physics.effects.base import Distortion, Parameter
from estexp_jax.physics.effects.damage import Damage
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import scalar_sensor_columns, scalar_sensor_sites
from estexp_jax.physics.model.robot import Robot


@register_effect
@final
class SensorGain(Distortion, Damage):
    """reading = gain * true."""

    name: ClassVar[str] = "sensor_gain"
    kind: ClassVar[str] = "sensor"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("gain", "", neutral=1.0),)
    equation: ClassVar[str] = "reading = gain * true"
    source: ClassVar[str] = "Bongard and Lipson 2004, section 2.2: a sensor fails by a percentage"
    gene: ClassVar[int | None] = 3

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return scalar_sensor_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return ((0.0, 2.0),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"the sensor {site} shows {100 * values['gain']:.3g} % of the true value"

    def at_amount(self, robot: Robot, site: str, amount: float, partner: int) -> dict[str, float]:
        return {"gain": 1.0 - amount}

    def combine(self, a: float, b: float) -> float:
        return 1.0 - (1.0 - a) * (1.0 - b)

    def distort(self, robot: Robot, readings: jax.Array, values: jax.Array) -> jax.Array:
        return readings.at[..., scalar_sensor_columns(robot)].multiply(values[:, 0])

    def restore(self, robot: Robot, readings: Any, values: Any) -> Any:
        true, gain = np.array(readings), np.asarray(values)[:, 0]
        columns = scalar_sensor_columns(robot)
        true[..., columns] = np.where(gain == 0.0, np.nan, true[..., columns] / np.where(gain == 0.0, 1.0, gain))
        return true
