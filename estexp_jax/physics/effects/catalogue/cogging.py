"""Cogging: a motor's magnets pull it into evenly spaced positions."""

from collections.abc import Mapping
from itertools import product
from typing import ClassVar, final

import jax.numpy as jnp
import mujoco
import numpy as np

from estexp_jax.physics.effects.base import Arrays, JointForce, JointState, Parameter, Term
from estexp_jax.physics.effects.guesses import Vectors
from estexp_jax.physics.effects.new_elements import add_passive_motor
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import is_slide, scalar_joint_sites
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot

_OFTEN, _OFTEN_SLIDE = (3.0, 60.0), (6.0, 500.0)
"""How often it may come in a turn, over 2 pi m of a slide. What comes less often is no cog: a spring, an unbalance."""
_PERIODS = 2.0
"""So many periods a joint must have gone through: fewer are a spring, an offset, a load."""


@register_effect
@final
class Cogging(Term):
    """tau = A sin(n q + phase)."""

    name: ClassVar[str] = "cogging"
    kind: ClassVar[str] = "joint"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("A", "N m"),
        Parameter("n", "1/rad", neutral=1.0),
        Parameter("phase", "rad", signed=True),
    )
    equation: ClassVar[str] = "tau = A sin(n q + phase)"
    in_mjcf: ClassVar[bool] = True
    extends_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "Hanselman, Brushless Permanent Magnet Motor Design, chapter 4"
    additive: ClassVar[bool] = True
    beside_laws: ClassVar[bool] = True
    sinusoidal: ClassVar[bool] = True

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return scalar_joint_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        most = 0.4 * scales.joint_torque(robot, robot.index("joint", site))
        return (0.0, most), _OFTEN_SLIDE if is_slide(robot, site) else _OFTEN, (-2.0 * np.pi, 2.0 * np.pi)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return (
            f"the joint {site} cogs with {values['A']:.3g} N m, {values['n']:.3g} times a turn, "
            f"at a phase of {values['phase']:.3g} rad"
        )

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        most = self.bounds(robot, site)[0][1]
        return [(0.05 * most, n, p) for n, p in product(np.arange(2.0, 16.0, 1.5), (-2.1, 0.0, 2.1))]

    def identifiable(self, robot: Robot, site: str, values: Mapping[str, float], observed: Observed) -> bool:
        low, high = observed.joint_range(robot, site)
        return not values["n"] * (high - low) < _PERIODS * 2.0 * np.pi

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        A, n, phase = p
        return JointForce(force=A * jnp.sin(n * joint.q + phase)), state

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        add_passive_motor(spec, f"{site}_cogging", site, cogging=[values[name] for name in ("A", "n", "phase")])
