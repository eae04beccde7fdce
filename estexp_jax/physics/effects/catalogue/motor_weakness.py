"""Motor weakness: a motor gives only a share of its torque."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from mujoco import mjx

from estexp_jax.physics.effects.base import Edit, Parameter
from estexp_jax.physics.effects.damage import Damage, ModelError
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import ALL_ALIKE, actuator_sites, driven_actuators, per_element, with_all
from estexp_jax.physics.model.robot import Robot, spec_element


@register_effect
@final
class MotorWeakness(Edit, Damage, ModelError):
    """force = max(1 - loss, 0) * nominal force: gain, bias and force range shrink together."""

    name: ClassVar[str] = "motor_weakness"
    kind: ClassVar[str] = "actuator"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("loss", "", signed=True),)
    equation: ClassVar[str] = "tau = (1 - loss) tau_nominal"
    in_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "Bongard and Lipson 2004, section 2.2"
    model_attribute: ClassVar[tuple[str, str] | None] = ("actuator", "*")
    is_loss: ClassVar[bool] = True
    gene: ClassVar[int | None] = 2

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return with_all(actuator_sites(robot))

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return ((-4.0, 1.0),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        loss = values["loss"]
        change = (
            f"lost {100 * loss:.3g} % of its strength"
            if loss >= 0
            else f"is {-100 * loss:.3g} % stronger than modelled"
        )
        return f"all motors alike ({site}): each {change}" if site == ALL_ALIKE else f"the motor {site} {change}"

    def nominal_value(self, robot: Robot, site: str) -> float:
        return 1.0

    def at_amount(self, robot: Robot, site: str, amount: float, partner: int) -> dict[str, float]:
        return {"loss": amount}

    def combine(self, a: float, b: float) -> float:
        return 1.0 - (1.0 - a) * (1.0 - b)

    def off_by(self, robot: Robot, site: str, error: float) -> dict[str, float]:
        return {"loss": error}

    def edit(self, robot: Robot, model: mjx.Model, values: jax.Array) -> mjx.Model:
        driven = np.array(driven_actuators(robot), dtype=int)
        loss = jnp.zeros(robot.model.nactuator, values.dtype).at[driven].add(per_element(values[:, 0], len(driven)))
        share = jnp.maximum(1.0 - loss, 0.0)[:, None]
        return model.replace(
            actuator_gainprm=model.actuator_gainprm * share,
            actuator_biasprm=model.actuator_biasprm * share,
            actuator_forcerange=model.actuator_forcerange * share,
        )

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        if site == ALL_ALIKE:
            for one in actuator_sites(robot):
                self.write_mjcf(robot, spec, one, values)
            return
        actuator = spec_element(spec, robot, "actuator", site)
        nominal = robot.model.actuator(robot.index("actuator", site))
        gain = float(nominal.gainprm[0])
        before = float(actuator.gainprm[0]) / gain if gain else 1.0  # less than 1 where a loss was written already
        share = max(before - values["loss"], 0.0)
        actuator.gainprm = nominal.gainprm * share
        actuator.biasprm = nominal.biasprm * share
        if share > 0.0:  # MJCF takes no empty range, and no force needs none
            actuator.forcerange = nominal.forcerange * share
