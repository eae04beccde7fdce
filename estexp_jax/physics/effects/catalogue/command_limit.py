"""Command limit: a servo's firmware leads its goal to the commanded one no faster than a profile allows."""

from collections.abc import Mapping, Sequence
from itertools import product
from typing import ClassVar, final

import jax.numpy as jnp

from estexp_jax.physics.effects.base import NEVER, Array, Arrays, CommandLaw, Parameter
from estexp_jax.physics.effects.guesses import Vectors
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.servos import goal_followers
from estexp_jax.physics.effects.sites import ALL_ALIKE, with_all
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording

_SPEEDS, _RATES = (0.03, 300.0), (0.1, 3e4)
"""Bounds of v and a, as multiples of a servo's reach a second, and a second squared."""
_FIRST = (0.3, 0.8, 2.0, 5.0, 12.0, 30.0), (8.0, 40.0, 200.0, 3e4)
"""Multiples of these that a search starts from; the last: at once."""


@register_effect
@final
class CommandLimit(CommandLaw):
    """The goal g follows the command with |dg/dt| <= v and |d2g/dt2| <= a, and stops where the command is.

    It brakes in time: its speed is at most that from which steps of a dt bring it to rest on what is left of the way,
    s + s^2 / (2 a dt) = |command - g| / dt with s = speed dt. The motor obeys the mean of g over the step.
    """

    name: ClassVar[str] = "command_limit"
    kind: ClassVar[str] = "actuator"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("v", "control unit/s", neutral=NEVER),
        Parameter("a", "control unit/s2", neutral=NEVER),
    )
    equation: ClassVar[str] = "u = g, dg/dt = r, |r| <= v, |dr/dt| <= a, g on its way to the command"
    source: ClassVar[str] = (
        "trapezoidal velocity profile: Siciliano et al., Robotics (2009), section 4.2.1; as in ROBOTIS, XL330-M288, "
        "Profile Velocity(112) and Profile Acceleration(108)"
    )
    n_states: ClassVar[int] = 2

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return with_all(goal_followers(robot))

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        reach = _reach(robot, site)
        return (_SPEEDS[0] * reach, _SPEEDS[1] * reach), (_RATES[0] * reach, _RATES[1] * reach)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        who = f"all servos ({site}) follow their goals" if site == ALL_ALIKE else f"the servo {site} follows its goal"
        return (
            f"{who} no faster than {values['v']:.3g} control units a second, gaining or losing no more than "
            f"{values['a']:.3g} a second in a second"
        )

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        reach = _reach(robot, site)
        return [(v * reach, a * reach) for v, a in product(*_FIRST)]

    def advice(self, recordings: Sequence[Recording]) -> tuple[str, ...]:
        return (
            "Record small and large steps of the command: the larger the step, the longer a limited goal takes; "
            "a lag or a delay takes as long for each.",
        )

    def initial(self, p: Arrays, command: Array) -> Arrays:
        return command, jnp.zeros_like(command)

    def act(self, p: Arrays, command: Array, idle: Array, dt: Array, state: Arrays) -> tuple[Array, Arrays]:
        (v, a), (goal, speed) = p, state
        left, half = command - goal, 0.5 * a * dt
        braking = 2.0 * a * jnp.abs(left) / (jnp.sqrt(jnp.square(half) + 2.0 * a * jnp.abs(left)) + half)
        wanted = jnp.sign(left) * jnp.minimum(jnp.minimum(braking, v), jnp.abs(left) / dt)
        after = speed + jnp.clip(wanted - speed, -a * dt, a * dt)
        limited = (v < NEVER) | (a < NEVER)
        moved = after * dt
        obeyed = jnp.where(limited, goal + 0.5 * moved, command)
        return obeyed, (jnp.where(limited, goal + moved, command), jnp.where(limited, after, 0.0))


def _reach(robot: Robot, site: str) -> float:
    """Size of a servo's commands; the largest of all of them."""
    names = goal_followers(robot) if site == ALL_ALIKE else (site,)
    return max(scales.command_reach(robot, robot.index("actuator", name)) for name in names)
