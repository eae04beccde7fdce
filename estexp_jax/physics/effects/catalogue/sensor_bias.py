"""Sensor bias: a reading is off by a constant."""

from collections.abc import Mapping
from typing import Any, ClassVar, final

import jax
import mujoco
import numpy as np

from estexp_jax.physics.effects.base import Distortion, Parameter
from estexp_jax.physics.effects.damage import Amounts, Damage
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import is_touch_sensor, scalar_sensor_columns, scalar_sensor_sites
from estexp_jax.physics.model.robot import Robot

_LARGEST = 0.5
"""Largest bias of a damaged angle sensor, rad."""


@register_effect
@final
class SensorBias(Distortion, Damage):
    """reading = true + bias."""

    name: ClassVar[str] = "sensor_bias"
    kind: ClassVar[str] = "sensor"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("bias", "sensor unit", signed=True),)
    equation: ClassVar[str] = "reading = true + bias"
    source: ClassVar[str] = "additive offset of a sensor's zero"
    amounts: ClassVar[Amounts] = Amounts(-1.0, 1.0, (-0.8, -0.4, -0.15, 0.15, 0.4, 0.8))

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return scalar_sensor_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        shows_position = robot.model.sensor_type[robot.index("sensor", site)] == mujoco.mjtSensor.mjSENS_JOINTPOS
        most = 0.5 if shows_position else 10.0
        return ((-most, most),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"the sensor {site} reads {values['bias']:+.3g} too much"

    def at_amount(self, robot: Robot, site: str, amount: float, partner: int) -> dict[str, float]:
        return {"bias": amount * _LARGEST}

    def damages(self, robot: Robot, site: str) -> bool:
        return not is_touch_sensor(robot, site)  # what is off by a constant has a scale

    def distort(self, robot: Robot, readings: jax.Array, values: jax.Array) -> jax.Array:
        return readings.at[..., scalar_sensor_columns(robot)].add(values[:, 0])

    def restore(self, robot: Robot, readings: Any, values: Any) -> Any:
        true = np.array(readings)
        true[..., scalar_sensor_columns(robot)] -= np.asarray(values)[:, 0]
        return true
