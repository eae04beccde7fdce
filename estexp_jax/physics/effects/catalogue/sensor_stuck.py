"""Sensor stuck: a sensor shows the same value all the time."""

from collections.abc import Mapping
from typing import Any, ClassVar, final

import jax
import jax.numpy as jnp
import numpy as np

from estexp_jax.physics.effects.base import NEVER, Distortion, Parameter
from estexp_jax.physics.effects.sites import scalar_sensor_columns, scalar_sensor_sites
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot


@final
class SensorStuck(Distortion):
    """reading = value."""

    name: ClassVar[str] = "sensor_stuck"
    kind: ClassVar[str] = "sensor"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("value", "sensor unit", neutral=NEVER, signed=True),)
    equation: ClassVar[str] = "reading = value"
    source: ClassVar[str] = "stuck-at fault: Isermann, Fault-Diagnosis Systems (2006), section 2.3"

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return scalar_sensor_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return (scales.sensor_span(robot, robot.index("sensor", site)),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"the sensor {site} is stuck at {values['value']:.3g}"

    def distort(self, robot: Robot, readings: jax.Array, values: jax.Array) -> jax.Array:
        columns = scalar_sensor_columns(robot)
        stuck = jnp.where(values[:, 0] < NEVER, values[:, 0], readings[..., columns])
        return readings.at[..., columns].set(stuck)

    def restore(self, robot: Robot, readings: Any, values: Any) -> Any:
        true, columns = np.array(readings), scalar_sensor_columns(robot)
        true[..., columns] = np.where(np.asarray(values)[:, 0] < NEVER, np.nan, true[..., columns])
        return true
