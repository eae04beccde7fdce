"""Sensor delay: a reading is old."""

from collections.abc import Mapping
from typing import ClassVar, final

import mujoco
import numpy as np

from estexp_jax.physics.effects.base import Parameter, ReadingShift
from estexp_jax.physics.effects.delays import add_delay, delay_refusal, is_longer_than_step
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import scalar_sensor_columns, scalar_sensor_sites
from estexp_jax.physics.model.robot import Robot, spec_element


@register_effect
@final
class SensorDelay(ReadingShift):
    """reading(t) = true(t - delay)."""

    name: ClassVar[str] = "sensor_delay"
    kind: ClassVar[str] = "sensor"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("delay", "s"),)
    equation: ClassVar[str] = "reading(t) = true(t - delay)"
    in_mjcf: ClassVar[bool] = True
    extends_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "transport delay; MuJoCo: sensor/delay"

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return scalar_sensor_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return ((0.0, 0.2),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"the sensor {site} shows what was {1000 * values['delay']:.3g} ms ago"

    def identifiable(self, robot: Robot, site: str, values: Mapping[str, float], observed: Observed) -> bool:
        return is_longer_than_step(robot, values["delay"])

    def mjcf_refusal(self, robot: Robot, site: str, values: Mapping[str, float]) -> str:
        return delay_refusal(robot, values["delay"])

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        add_delay(spec, spec_element(spec, robot, "sensor", site), values["delay"])

    def shift(self, robot: Robot, values: np.ndarray) -> np.ndarray:
        ages = np.zeros((*values.shape[:-2], robot.model.nsensordata))
        ages[..., scalar_sensor_columns(robot)] = np.maximum(values[..., 0], 0.0)
        return ages
