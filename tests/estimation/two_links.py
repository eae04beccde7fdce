"""An arm of two identical links, and logs of it, of other arms like it, and of logs gone wrong."""

from functools import cache

import mujoco
import numpy as np

from estexp_jax.physics.effects.changes import parse_change
from estexp_jax.physics.effects.logging_fault import LoggingFault
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording

XML = """<mujoco><compiler angle="radian"/><option timestep="0.002" integrator="implicitfast"/>
<default><geom contype="0" conaffinity="0" type="capsule" fromto="0 0 0 .25 0 0" size=".02" mass="{mass}"/>
 <joint axis="0 1 0" damping="{damping}" armature=".02" frictionloss="{friction}"/></default>
<worldbody><body pos="0 0 1"><joint name="shoulder"/><geom/>
 <body pos=".25 0 0"><joint name="elbow"/><geom/></body></body></worldbody>
<actuator><{motor} name="m_shoulder" joint="shoulder" {gain}/><{motor} name="m_elbow" joint="elbow" {gain}/></actuator>
<sensor><jointpos name="q_shoulder" joint="shoulder"/><jointpos name="q_elbow" joint="elbow"/></sensor></mujoco>"""
RATE = 250.0


@cache
def arm(motor: str = "position", friction: float = 0.0, mass: float = 0.4, damping: float = 0.2) -> Robot:
    """The arm with position servos or torque motors."""
    gain = 'kp="20" kv=".5"' if motor == "position" else 'gear="2"'
    return Robot.from_string(XML.format(motor=motor, gain=gain, friction=friction, mass=mass, damping=damping))


@cache
def log_of(real: Robot, seed: int = 0, length: float = 8.0, role: str = "train") -> Recording:
    """A log of an arm, with noise and encoder steps."""
    draw, model, data = np.random.default_rng(seed), real.model, mujoco.MjData(real.model)
    time = np.arange(-1.0, length, 1.0 / RATE)
    phase = 2.0 * np.pi * (draw.uniform(0.2, 1.2, (2, 4)) * time[:, None, None] + draw.uniform(0.0, 1.0, (2, 4)))
    ctrl, rows = 0.25 * np.sin(phase).sum(axis=2), []
    for u in ctrl:
        rows.append(data.qpos + draw.normal(0.0, 3e-4, 2))
        data.ctrl[:] = u
        mujoco.mj_step(model, data, 2)
    kept, step = time >= 0.0, 2.0 * np.pi / 2**14
    readings = np.round(np.array(rows)[kept] / step) * step
    nothing, on = np.full(readings.shape, np.nan), np.ones(readings.shape)
    return Recording(f"{role}_{seed}.csv", time[kept], ctrl[kept], on, readings, nothing, nothing, role=role)


def faulty(robot: Robot, recording: Recording, *faults: str) -> Recording:
    """A log in which something went wrong, each as `record --effect` takes it."""
    for text in faults:
        change = parse_change(text, robot)
        fault = effect(change.effect)
        assert isinstance(fault, LoggingFault)
        recording = fault.logged(robot, recording, change.name or "", change.values)
    return recording
