"""Where effects can act: the usual lists of sites, and how a site's index is found."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from estexp_jax.physics.model.actuators import affine_actuators
from estexp_jax.physics.model.robot import Robot

ALL_ALIKE = "*"
"""The site that stands for all elements alike."""


def scalar_joint_sites(robot: Robot) -> tuple[str, ...]:
    """Names of the hinge and slide joints."""
    names = robot.names("joint")
    return tuple(names[i] for i in robot.scalar_joints)


_MOST_SINGLE = 3
"""Up to so many joints with friction are reported one by one."""


def friction_sites(robot: Robot) -> tuple[str, ...]:
    """`scalar_joint_sites`, and of many all of them alike: what is missing at one is mostly missing at each."""
    names, kinds = scalar_joint_sites(robot), set(robot.model.jnt_type[list(robot.scalar_joints)].tolist())
    return with_all(names) if len(names) > _MOST_SINGLE and len(kinds) == 1 else names


def joints_at(robot: Robot, site: str) -> tuple[str, ...]:
    """The joints that a site of `friction_sites` stands for."""
    return scalar_joint_sites(robot) if site == ALL_ALIKE else (site,)


def joint_subject(site: str) -> str:
    """The subject of what is said about a joint, or about all of them."""
    return f"every joint ({site})" if site == ALL_ALIKE else f"the joint {site}"


def joint_dofs(robot: Robot) -> np.ndarray:
    """Velocity address of each of `scalar_joint_sites`."""
    return robot.model.jnt_dofadr[list(robot.scalar_joints)]


def is_slide(robot: Robot, joint: str) -> bool:
    """Whether a joint is a slide."""
    return int(robot.model.jnt_type[robot.index("joint", joint)]) == int(mujoco.mjtJoint.mjJNT_SLIDE)


def angle_unit(robot: Robot, spec: mujoco.MjSpec, joint: str) -> float:
    """What a description's numbers for a joint's position are in, rad or m: hinges may count in degrees."""
    return float(np.pi / 180.0) if spec.compiler.degree and not is_slide(robot, joint) else 1.0


def driven_joint_sites(robot: Robot) -> tuple[str, ...]:
    """Names of the hinge and slide joints that `driven_actuators` drive, and no other kind of actuator directly."""
    names, own = robot.names("joint"), set(driven_actuators(robot))
    driven = {robot.joint_of_actuator(a) for a in own}
    driven -= {robot.joint_of_actuator(a) for a in range(robot.model.nactuator) if a not in own}
    return tuple(names[j] for j in robot.scalar_joints if j in driven)


def driven_actuators(robot: Robot) -> tuple[int, ...]:
    """Indices of the actuators that drive a hinge or slide joint directly, with a force that is affine in one input."""
    affine = np.flatnonzero(affine_actuators(robot.model)).tolist()
    return tuple(a for a in affine if robot.joint_of_actuator(a) in robot.scalar_joints)


def actuator_sites(robot: Robot) -> tuple[str, ...]:
    """Names of `driven_actuators`."""
    names = robot.names("actuator")
    return tuple(names[a] for a in driven_actuators(robot))


def with_all(names: tuple[str, ...]) -> tuple[str, ...]:
    """Sites of an effect that may also act on all of them alike: one more, `*`, after the others."""
    return (*names, ALL_ALIKE) if len(names) > 1 else names


def per_element(values: Any, n: int) -> Any:
    """Values (n, ...) of n elements, of values at the sites that `with_all` gives: their own and the common one."""
    return values[:n] + values[n] if len(values) > n else values


def actuator_dofs(robot: Robot) -> np.ndarray:
    """Velocity address of the joint of each of `driven_actuators`."""
    return np.array([robot.model.jnt_dofadr[robot.joint_of_actuator(a)] for a in driven_actuators(robot)], dtype=int)


def body_sites(robot: Robot) -> tuple[str, ...]:
    """Names of the bodies that have mass and can move."""
    model, names = robot.model, robot.names("body")
    return tuple(names[b] for b in range(1, model.nbody) if model.body_mass[b] > 0.0 and model.body_weldid[b] != 0)


def scalar_sensor_sites(robot: Robot) -> tuple[str, ...]:
    """Names of the sensors with one value."""
    return tuple(n for n, dim in zip(robot.names("sensor"), robot.model.sensor_dim, strict=True) if dim == 1)


def scalar_sensor_columns(robot: Robot) -> np.ndarray:
    """Address in `sensordata` of each of `scalar_sensor_sites`."""
    return robot.model.sensor_adr[robot.model.sensor_dim == 1]


def is_touch_sensor(robot: Robot, sensor: str) -> bool:
    """Whether a sensor is MuJoCo's touch sensor."""
    return int(robot.model.sensor_type[robot.index("sensor", sensor)]) == int(mujoco.mjtSensor.mjSENS_TOUCH)


def smallest_of_joints(robot: Robot, values: np.ndarray, site: str) -> float:
    """The smallest of values (nv,) at the joints that a site stands for."""
    joints = [robot.index("joint", one) for one in joints_at(robot, site)]
    return float(values[robot.model.jnt_dofadr[joints]].min())


def lost_bodies(robot: Robot) -> tuple[str, ...]:
    """Names of the bodies that can come off: those on hinges or slides, unless nothing that moves would be left."""
    model, names = robot.model, robot.names("body")
    free, joints = int(mujoco.mjtJoint.mjJNT_FREE), set(model.jnt_bodyid.tolist())
    return tuple(
        names[b]
        for b in range(1, model.nbody)
        if model.body_jntnum[b] > 0
        and int(model.jnt_type[model.body_jntadr[b]]) != free
        and joints - set(robot.subtree(b))
    )
