"""The plainest terms. The catalogue has effects that say the same, so they count only where these are left out."""

from collections.abc import Mapping
from itertools import product
from typing import ClassVar, final

import jax.numpy as jnp
import mujoco
import numpy as np

from estexp_jax.physics.effects.base import Arrays, JointForce, JointState, Parameter
from estexp_jax.physics.effects.laws.base import (
    PHASES,
    ROUND,
    WAVES,
    Bounds,
    JointLaw,
    Reach,
    Shapeless,
    amplitude,
    away,
    half_span,
    signed,
    torque,
)
from estexp_jax.physics.effects.passive import add_damper, add_spring
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot, spec_element

_DENSEST = 60.0
"""Largest spatial frequency, 1/rad or 1/m."""
_FREQUENCIES = 20_000
"""Of so many at most a look is taken: a joint that ran away does not ask for more memory than there is."""


@final
class LawDamping(Shapeless):
    """tau = -c w."""

    name: ClassVar[str] = "law_damping"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("c", "N m s/rad", signed=False),)
    equation: ClassVar[str] = "tau = -c w"
    in_mjcf: ClassVar[bool] = True
    resembles: ClassVar[str] = "a resistance in proportion to speed"
    stands_for: ClassVar[str] = "viscous_friction"

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(-values["c"], "w")

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(damping=p[0]), state

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        add_damper(robot, spec, site, (values["c"], 0.0, 0.0))


@final
class LawDrag(Shapeless):
    """tau = -c |w| w."""

    name: ClassVar[str] = "law_drag"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("c", "N m s2/rad2", signed=False),)
    equation: ClassVar[str] = "tau = -c |w| w"
    in_mjcf: ClassVar[bool] = True
    resembles: ClassVar[str] = "a resistance that grows with the square of speed, as fluid drag does"
    stands_for: ClassVar[str] = "quadratic_drag"

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(-values["c"], "|w| w")

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(damping=p[0] * jnp.abs(moment.w)), state

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        add_damper(robot, spec, site, (0.0, values["c"], 0.0))


@final
class LawDryFriction(Shapeless):
    """tau = -T sign(w)."""

    name: ClassVar[str] = "law_dry_friction"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("T", "N m", signed=False),)
    equation: ClassVar[str] = "tau = -T sign(w)"
    in_mjcf: ClassVar[bool] = True
    resembles: ClassVar[str] = "a resistance that is the same at all speeds"
    stands_for: ClassVar[str] = "coulomb_friction"
    arms: ClassVar[tuple[str, ...]] = ("dof_frictionloss",)

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(-values["T"], "sign(w)")

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(friction=p[0]), state

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        spec_element(spec, robot, "joint", site).frictionloss += values["T"]


@final
class LawInertia(Shapeless):
    """tau = -I dw/dt."""

    name: ClassVar[str] = "law_inertia"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("I", "kg m2", signed=False),)
    equation: ClassVar[str] = "tau = -I dw/dt"
    in_mjcf: ClassVar[bool] = True
    resembles: ClassVar[str] = "a resistance to changes of speed, as of an inertia"
    stands_for: ClassVar[str] = "armature"

    def most(self, robot: Robot, joint: int) -> float:
        return scales.rotor_inertia(robot, joint)

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(-values["I"], "dw/dt")

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(inertia=p[0]), state

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        spec_element(spec, robot, "joint", site).armature += values["I"]


@final
class LawPush(Shapeless):
    """tau = T."""

    name: ClassVar[str] = "law_push"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("T", "N m"),)
    equation: ClassVar[str] = "tau = T"
    resembles: ClassVar[str] = "a push that is always the same"
    stands_for: ClassVar[str] = "torque_offset"

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(values["T"], "")

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(force=p[0] + jnp.zeros_like(moment.q)), state


@final
class LawSpring(JointLaw):
    """tau = -k (q - q0), of either sign."""

    name: ClassVar[str] = "law_spring"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("k", "N m/rad"), Parameter("q0", "rad", signed=True))
    equation: ClassVar[str] = "tau = -k (q - q0)"
    in_mjcf: ClassVar[bool] = True
    resembles: ClassVar[str] = "a spring"
    stands_for: ClassVar[str] = "joint_stiffness"

    def most(self, robot: Robot, joint: int) -> float:
        return 10.0 * torque(robot, joint) / half_span(robot, joint)

    def shapes(self, robot: Robot, joint: int) -> Bounds:
        return (scales.joint_span(robot, joint),)

    def tried(self, reach: Reach) -> list[tuple[float, ...]]:
        return [(q,) for q in (reach.low, *reach.places(3), reach.high)]

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(-values["k"], away("q", values["q0"]))

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(force=-p[0] * (moment.q - p[1])), state

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        add_spring(robot, spec, site, (values["k"], 0.0, 0.0), values["q0"])


@final
class LawWave(JointLaw):
    """tau = A sin(n q + phase)."""

    name: ClassVar[str] = "law_wave"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        amplitude("A", "N m", signed=False),
        Parameter("n", "1/rad", neutral=1.0),
        Parameter("phase", "rad", signed=True),
    )
    equation: ClassVar[str] = "tau = A sin(n q + phase)"
    resembles: ClassVar[str] = "a force that comes again and again along the way, as the poles of a motor pass"
    stands_for: ClassVar[str] = "cogging"

    def most(self, robot: Robot, joint: int) -> float:
        return torque(robot, joint)

    def shapes(self, robot: Robot, joint: int) -> Bounds:
        return (0.1, _DENSEST), ROUND

    def tried(self, reach: Reach) -> list[tuple[float, ...]]:
        apart = max(0.5 / reach.span, (_DENSEST - 1.0) / _FREQUENCIES)
        dense = np.arange(1.0, _DENSEST, apart).tolist()
        return [(n, phase) for n, phase in product((*WAVES, *dense), PHASES)]

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(values["A"], f"sin({values['n']:.4g} q {signed(values['phase'], '')})")

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(force=p[0] * jnp.sin(p[1] * moment.q + p[2])), state
