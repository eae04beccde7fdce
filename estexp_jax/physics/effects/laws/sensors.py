"""Unknown laws of sensors."""

from collections.abc import Mapping
from typing import ClassVar, final

import mujoco
import numpy as np

from estexp_jax.physics.effects.base import Parameter, ReadingDrift
from estexp_jax.physics.effects.laws.base import signed_text
from estexp_jax.physics.effects.sites import scalar_sensor_columns, scalar_sensor_sites
from estexp_jax.physics.model.robot import Robot


@final
class LawDrift(ReadingDrift):
    """reading = true + a t, t the time since the recording began: a zero that wanders, as sensors warm up or slip."""

    name: ClassVar[str] = "law_drift"
    kind: ClassVar[str] = "sensor"
    named: ClassVar[bool] = False
    tried_beside: ClassVar[str] = "sensor_bias"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("a", "sensor unit/s", signed=True),)
    equation: ClassVar[str] = "reading = true + a t, t the time since the recording began"
    source: ClassVar[str] = "zero drift: Isermann, Fault-Diagnosis Systems (2006), section 2.3"

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return scalar_sensor_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        shows_position = robot.model.sensor_type[robot.index("sensor", site)] == mujoco.mjtSensor.mjSENS_JOINTPOS
        largest = 0.2 if shows_position else 4.0
        return ((-largest, largest),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"the sensor {site} wanders by {values['a']:+.3g} a second, as no effect of the catalogue does"

    def equation_with_values(self, values: Mapping[str, float]) -> str:
        return f"reading = true {signed_text(values['a'], 't')}, t the time since the recording began"

    def rate(self, robot: Robot, values: np.ndarray) -> np.ndarray:
        gained = np.zeros((*values.shape[:-2], robot.model.nsensordata))
        gained[..., scalar_sensor_columns(robot)] = values[..., 0]
        return gained
