"""Readings that show hidden variables: of a motor's sensors where it turns a rotor instead of its joint, and others.

The joint gets what the rotor passes on, so the engine's own motor stands still; its torque is a hidden variable.
"""

from __future__ import annotations

from typing import NamedTuple

import mujoco

from estexp_jax.physics.effects.base import Term
from estexp_jax.physics.effects.registry import Catalogue
from estexp_jax.physics.effects.sites import driven_actuators
from estexp_jax.physics.model.actuators import gear_of
from estexp_jax.physics.model.robot import Robot


class MotorReading(NamedTuple):
    """A hidden variable at one element, to be added to one value of `sensordata`."""

    column: int
    effect: str
    state: int
    row: int  # of the element
    factor: float


def motor_readings(robot: Robot, catalogue: Catalogue) -> list[MotorReading]:
    """All that sensors show of a catalogue's hidden variables, those of motors' forces of its rotors."""
    model, found = robot.model, []
    on_joint = {a: robot.joint_of_actuator(a) for a in driven_actuators(robot)}
    for e in catalogue:
        if not isinstance(e, Term):
            continue
        found += [MotorReading(s.column, e.name, s.state, s.element, s.factor) for s in e.displayed(robot)]
        if e.motor_torque_state is None:
            continue
        for row, dof in enumerate(e.dofs(robot)):
            joint = int(model.dof_jntid[dof])
            motors = [a for a, j in on_joint.items() if j == joint]
            for sensor in range(model.nsensor):
                kind, at = int(model.sensor_type[sensor]), int(model.sensor_objid[sensor])
                factor = 0.0
                if kind == int(mujoco.mjtSensor.mjSENS_ACTUATORFRC) and at in motors:
                    factor = 1.0 / (gear_of(model, at) * len(motors))
                elif kind == int(mujoco.mjtSensor.mjSENS_JOINTACTFRC) and at == joint:
                    factor = 1.0
                if factor:
                    found.append(MotorReading(int(model.sensor_adr[sensor]), e.name, e.motor_torque_state, row, factor))
    return found
