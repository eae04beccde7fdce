"""Sensor stuck: a sensor shows the same value all the time."""

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, final

import jax
import jax.numpy as jnp
import numpy as np

from estexp_jax.physics.effects.base import NEVER, Distortion, Parameter
from estexp_jax.physics.effects.damage import Amounts, Damage
from estexp_jax.physics.effects.guesses import Vectors
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import is_touch_sensor, scalar_sensor_columns, scalar_sensor_sites
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.reading_noise import holds_still
from estexp_jax.physics.recording import Recording

_LAST = 2 / 3
"""Share of a recording after which a fault that begins part-way has begun."""
_SWING = np.pi / 4
"""Angle at which a damaged sensor is stuck at most, rad."""


@register_effect
@final
class SensorStuck(Distortion, Damage):
    """reading = value."""

    name: ClassVar[str] = "sensor_stuck"
    kind: ClassVar[str] = "sensor"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("value", "sensor unit", neutral=NEVER, signed=True),)
    equation: ClassVar[str] = "reading = value"
    source: ClassVar[str] = "stuck-at fault: Isermann, Fault-Diagnosis Systems (2006), section 2.3"
    masks_readings: ClassVar[bool] = True
    amounts: ClassVar[Amounts] = Amounts(-1.0, 1.0, (-1.0, -0.6, -0.2, 0.2, 0.6, 1.0))
    acts_at_zero: ClassVar[bool] = True

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return scalar_sensor_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return (scales.sensor_span(robot, robot.index("sensor", site)),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"the sensor {site} is stuck at {values['value']:.3g}"

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        return [(float(np.nan_to_num(observed.median_reading(robot, site))),)]

    def feasible(self, robot: Robot, site: str, recordings: Sequence[Recording]) -> bool:
        return all(holds_still(robot, r, site, _LAST) for r in recordings if r.role == "train")

    def at_amount(self, robot: Robot, site: str, amount: float, partner: int) -> dict[str, float]:
        return {"value": amount * (1.0 if is_touch_sensor(robot, site) else _SWING)}

    def combine(self, a: float, b: float) -> float:
        return a

    def distort(self, robot: Robot, readings: jax.Array, values: jax.Array) -> jax.Array:
        columns = scalar_sensor_columns(robot)
        stuck = jnp.where(values[:, 0] < NEVER, values[:, 0], readings[..., columns])
        return readings.at[..., columns].set(stuck)

    def restore(self, robot: Robot, readings: Any, values: Any) -> Any:
        true, columns = np.array(readings), scalar_sensor_columns(robot)
        true[..., columns] = np.where(np.asarray(values)[:, 0] < NEVER, np.nan, true[..., columns])
        return true
