"""The torque a motor puts on its joint before a step, in lanes: as `physics.motors`, by which it is explained."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, final

import jax.numpy as jnp
import mujoco

from estexp_jax.lanes.algebra import Scalar
from estexp_jax.lanes.layout import Layout
from estexp_jax.lanes.model_parameters import ModelParameters
from estexp_jax.physics.model.robot import Robot

_AFFINE_GAIN, _AFFINE_BIAS = int(mujoco.mjtGain.mjGAIN_AFFINE), int(mujoco.mjtBias.mjBIAS_AFFINE)


class MotorInputs(NamedTuple):
    """Inputs of the motors, rows (N,) by index.

    Attributes:
        commands: in force, within their ranges.
        enable: 1.0 where a motor is on.
        share: factors on the motors so far; 1 where there is none.
    """

    commands: Sequence[Any]
    enable: Any
    share: Mapping[int, Scalar]


@final
class Motors:
    """The motors of robots of these numbers."""

    def __init__(self, robot: Robot, layout: Layout, params: ModelParameters) -> None:
        """Of a plan's robot."""
        self._robot, self._layout, self._params = robot, layout, params

    def limited(self, a: int, command: Any) -> Any:
        """A command (N,) within its range."""
        if not self._layout.model.actuator_ctrllimited[a]:
            return command
        return jnp.clip(command, *(self._number("actuator_ctrlrange", a, i) for i in range(2)))

    def idle(self, a: int, position: Mapping[int, Any], speed: Mapping[int, Any]) -> Any:
        """As `motors.idle_commands`, from positions and speeds (N,) by velocity address."""
        joint, model = self._robot.joint_of_actuator(a), self._layout.model
        assert joint is not None
        address = int(model.jnt_dofadr[joint])
        zero = jnp.zeros_like(position[address])
        if model.actuator_biastype[a] != _AFFINE_BIAS:
            return zero
        gear, gain = self._number("actuator_gear", a, 0), self._number("actuator_gainprm", a, 0)
        b = [self._number("actuator_biasprm", a, i) for i in range(3)]
        at_rest = b[0] + b[1] * gear * position[address]
        moving = b[0] + b[2] * gear * speed[address]
        bias: Any = jnp.where(jnp.asarray(b[1]) != 0.0, at_rest, moving)
        known = jnp.asarray(gain) != 0.0
        found: Any = jnp.where(known, -bias / jnp.where(known, gain, 1.0), 0.0)
        return found + zero

    def asked(
        self, site: Sequence[int], position: Mapping[int, Any], speed: Mapping[int, Any], inputs: MotorInputs
    ) -> tuple[Any, Any]:
        """As `motors.asked_torques`, (N,) of the motors at a site together, as scaled so far."""
        in_all: Any = jnp.zeros_like(next(iter(position.values())))
        beyond = in_all
        for a in site:
            strength = self._strength(a, inputs.share) * inputs.enable[a]
            in_all = in_all + strength * inputs.commands[a]
            beyond = beyond + strength * (inputs.commands[a] - self.idle(a, position, speed))
        return in_all, beyond

    def further(
        self, site: Sequence[int], commands: Sequence[Any], share: Mapping[int, Scalar], more: Any
    ) -> list[Any]:
        """Commands that ask for so much more torque (N,) at a site, as `motors.Drives.further`."""
        found = list(commands)
        for a in site:
            strength = jnp.asarray(self._strength(a, share))
            part = more / len(site) / jnp.where(strength == 0.0, 1.0, strength)
            found[a] = commands[a] + jnp.where(strength == 0.0, 0.0, part)
        return found

    def torque(self, site: Sequence[int], q: Any, w: Any, inputs: MotorInputs, *, whole: bool) -> Any:
        """Torque (N,) of the motors at a site at these positions and speeds, as scaled so far.

        Args:
            site: their indices.
            q: rad or m.
            w: speeds.
            inputs: of the motors.
            whole: whether the joint's common limit counts.
        """
        model, total = self._layout.model, jnp.zeros_like(q)
        for a in site:
            gear = self._number("actuator_gear", a, 0)
            length, rate = gear * q, gear * w
            gain = self._number("actuator_gainprm", a, 0)
            if model.actuator_gaintype[a] == _AFFINE_GAIN:
                gain = gain + sum(self._number("actuator_gainprm", a, i) * x for i, x in ((1, length), (2, rate)))
            force = gain * inputs.commands[a]
            if model.actuator_biastype[a] == _AFFINE_BIAS:
                b = [self._number("actuator_biasprm", a, i) for i in range(3)]
                force = force + b[0] + b[1] * length + b[2] * rate
            force = force * inputs.enable[a]
            if model.actuator_forcelimited[a]:
                force = jnp.clip(force, *(self._number("actuator_forcerange", a, i) for i in range(2)))
            total = total + gear * force * inputs.share.get(a, 1.0)
        joint = self._robot.joint_of_actuator(site[0]) if site and whole else None
        if joint is not None and model.jnt_actfrclimited[joint]:
            total = jnp.clip(total, *(self._number("jnt_actfrcrange", joint, i) for i in range(2)))
        return total

    def _strength(self, a: int, share: Mapping[int, Scalar]) -> Any:
        """Torque for each unit of a motor's command."""
        return self._number("actuator_gear", a, 0) * self._number("actuator_gainprm", a, 0) * share.get(a, 1.0)

    def _number(self, name: str, element: int, column: int | None = None) -> Scalar:
        return self._params.get(name, [element], column)
