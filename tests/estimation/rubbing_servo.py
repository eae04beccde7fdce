"""A servo whose joint rubs at rest, which its model does not know, and logs of it with rests."""

import mujoco
import numpy as np

from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording

_XML = """<mujoco><compiler angle="radian"/><option timestep="0.0025" integrator="implicitfast"/><worldbody><body>
<joint name="elbow" axis="0 1 0" armature=".03" damping=".4" frictionloss="{friction}"/>
<geom type="capsule" fromto="0 0 0 .25 0 0" size=".015" mass=".4" contype="0" conaffinity="0"/></body></worldbody>
<actuator><position name="servo" joint="elbow" kp="18" kv=".3" forcerange="-9 9"/></actuator>
<sensor><jointpos name="angle" joint="elbow"/></sensor></mujoco>"""
RATE, REST_S = 200.0, 0.6


def servo(friction: float = 0.0) -> Robot:
    """The servo with dry friction, N m."""
    return Robot.from_string(_XML.format(friction=friction), "servo.xml")


def rubbing_log(seed: int, friction: float = 0.35, seconds: float = 8.0) -> Recording:
    """A log of a servo with friction: commands at half the rate of readings, which have encoder steps; two rests."""
    draw, model = np.random.default_rng(seed), servo(friction).model
    data, time = mujoco.MjData(model), np.arange(0.0, seconds, 1.0 / RATE)
    rate, phase = draw.uniform(0.1, 0.9, 4), draw.uniform(0.0, 2.0 * np.pi, 4)
    goal = (draw.uniform(0.3, 1.0, 4) * (np.sin(2.0 * np.pi * rate * time[:, None] + phase) - np.sin(phase))).sum(
        axis=1
    )
    goal *= np.minimum(time / 0.5, 1.0) / np.abs(goal).max()
    for begin in draw.uniform(0.2, 0.8, 2) * seconds:
        resting = (time >= begin) & (time < begin + REST_S)
        goal[resting] = goal[np.argmax(resting)]
    goal = goal[np.arange(len(goal)) // 2 * 2]
    angles = []
    for u in goal:
        angles.append(float(data.qpos[0]))
        data.ctrl[:] = u
        mujoco.mj_step(model, data, 2)
    step = 2.0 * np.pi / 2**14
    readings = (np.round(np.array(angles) / step) * step)[:, None]
    nothing = np.full(readings.shape, np.nan)
    return Recording(
        "servo.csv", time, goal[:, None], np.ones(readings.shape), readings, nothing, nothing, role="train"
    )
