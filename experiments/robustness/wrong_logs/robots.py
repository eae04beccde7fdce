"""Three robots and logs of them: small servos, a leg whose joints are driven by torques, and an arm of six joints."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import final

import mujoco
import numpy as np

from estexp_jax.physics.model.robot import Robot

_HEAD = """<mujoco><compiler angle="radian"/><option timestep="0.002" integrator="implicitfast"/>
<default><geom contype="0" conaffinity="0"/><joint damping="{damping}" armature="{armature}" limited="true"/></default>
<worldbody>{bodies}</worldbody><actuator>{motors}</actuator><sensor>{sensors}</sensor></mujoco>"""


@final
@dataclass(frozen=True)
class Kind:
    """A kind of robot: its links' axes, lengths and masses, and what drives it."""

    axes: tuple[str, ...]
    lengths: tuple[float, ...]
    masses: tuple[float, ...]
    is_servo: bool
    gains: tuple[float, ...]
    damping: float
    armature: float
    rate: float


_Y, _Z = "0 1 0", "0 0 1"
ROBOTS = {
    "servos": Kind((_Y, _Y), (0.25, 0.25), (0.4, 0.3), True, (20.0, 20.0), 0.2, 0.02, 250.0),
    "torques": Kind((_Y, _Y, _Y), (0.3, 0.3, 0.15), (2.0, 1.5, 0.5), False, (60.0, 40.0, 10.0), 0.3, 0.05, 250.0),
    "arm": Kind(
        (_Z, _Y, _Y, _Y, _Z, _Y),
        (0.2, 0.3, 0.3, 0.1, 0.1, 0.1),
        (2.0, 2.0, 1.5, 0.8, 0.5, 0.3),
        True,
        (300.0, 300.0, 200.0, 60.0, 40.0, 30.0),
        1.0,
        0.1,
        100.0,
    ),
}


@cache
def robot_of(name: str, friction: float = 0.0, heavier: float = 1.0) -> Robot:
    """A robot as it is modelled, or one that has more friction and masses than that."""
    kind, bodies = ROBOTS[name], ""
    for k, (axis, length, mass) in enumerate(zip(kind.axes, kind.lengths, kind.masses, strict=True)):
        at = f"{kind.lengths[k - 1]} 0 0" if k else "0 0 1"
        bodies += f'<body pos="{at}"><joint name="j{k}" axis="{axis}" range="-2.6 2.6" frictionloss="{friction}"/>'
        bodies += f'<geom type="capsule" fromto="0 0 0 {length} 0 0" size=".02" mass="{mass * heavier}"/>'
    bodies += "</body>" * len(kind.axes)
    each = range(len(kind.axes))
    servo = '<position name="m{0}" joint="j{0}" kp="{1}" kv="{2}"/>'
    motor = '<motor name="m{0}" joint="j{0}" gear="{1}"/>'
    gains = zip(each, kind.gains, strict=True)
    motors = "".join((servo if kind.is_servo else motor).format(k, gain, 0.05 * gain) for k, gain in gains)
    sensors = "".join(f'<jointpos name="q{k}" joint="j{k}"/>' for k in each)
    text = _HEAD.format(damping=kind.damping, armature=kind.armature, bodies=bodies, motors=motors, sensors=sensors)
    return Robot.from_string(text, f"{name}.xml")


def log_of(name: str, draw: np.random.Generator, seconds: float = 8.0) -> dict[str, np.ndarray]:
    """Columns of a right log of a robot that rubs, and weighs a little more or less than its model, with noise."""
    kind = ROBOTS[name]
    real = robot_of(name, 0.02 * max(kind.gains) * 0.05, float(draw.uniform(0.95, 1.05)))
    model, data, count = real.model, mujoco.MjData(real.model), len(kind.axes)
    substeps = round(1.0 / (kind.rate * model.opt.timestep))
    time = np.arange(-1.0, seconds, 1.0 / kind.rate)
    phase = (
        2.0 * np.pi * (draw.uniform(0.15, 0.9, (count, 4)) * time[:, None, None] + draw.uniform(0.0, 1.0, (count, 4)))
    )
    wanted = np.clip(0.25 * np.sin(phase).sum(axis=2), -1.2, 1.2)
    data.qpos[:] = wanted[0]
    commands, readings = [], []
    for target in wanted:
        readings.append(data.qpos + draw.normal(0.0, 2e-4, count))
        command = target if kind.is_servo else _torques(model, data, target, kind)
        commands.append(command)
        data.ctrl[:] = command
        mujoco.mj_step(model, data, substeps)
    kept, step = time >= 0.0, 2.0 * np.pi / 2**14
    columns = {"time": time[kept]}
    columns |= {f"ctrl.m{k}": np.array(commands)[kept, k] for k in range(count)}
    rounded = np.round(np.array(readings)[kept] / step) * step
    return columns | {f"sensor.q{k}": rounded[:, k] for k in range(count)}


def _torques(model: mujoco.MjModel, data: mujoco.MjData, target: np.ndarray, kind: Kind) -> np.ndarray:
    """Commands of a controller with gravity compensation, in units of each motor's gear."""
    gains = np.array(kind.gains)
    return (gains * (target - data.qpos) - 0.1 * gains * data.qvel + data.qfrc_bias) / gains
