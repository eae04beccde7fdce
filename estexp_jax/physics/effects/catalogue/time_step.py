"""Time step: the simulator steps too coarsely."""

from collections.abc import Mapping
from typing import ClassVar, final

import mujoco

from estexp_jax.physics.effects.base import Effect, Parameter
from estexp_jax.physics.model.robot import Robot


@final
class TimeStep(Effect):
    """The nominal step makes the mismatch, which vanishes at this one. No hypothesis holds it: all are run finer."""

    name: ClassVar[str] = "time_step"
    kind: ClassVar[str] = "numerics"
    side: ClassVar[str] = "numerics"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("step", "s"),)
    equation: ClassVar[str] = "the integrator's error, proportional to the step"
    in_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "MuJoCo, Computation: numerical integration"

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return ("",)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return ((1e-6, float(robot.model.opt.timestep)),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"the simulator's time step is too long: its error vanishes in the noise at {values['step']:.2g} s"

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        spec.option.timestep = values["step"]
