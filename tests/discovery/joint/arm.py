"""An arm of four driven joints; its logs are made by plain MuJoCo at a tenth of the step."""

from __future__ import annotations

from functools import cache

import mujoco
import numpy as np

from estexp_jax.discovery.diagnosis import Case
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording

NOMINAL = """<mujoco><option timestep="0.004" integrator="implicitfast"><flag contact="disable"/></option><worldbody>
<body name="l1"><joint name="j1" axis="0 0 1" armature="0.05"/><geom type="capsule" size="0.04" fromto="0 0 0 0 0 .3"
  mass="4"/><body name="l2" pos="0 0 0.3"><joint name="j2" axis="0 1 0" armature="0.05"/><geom type="capsule"
  size="0.04" fromto="0 0 0 0.35 0 0" mass="3"/><body name="l3" pos="0.35 0 0"><joint name="j3" axis="0 1 0"
  armature="0.03"/><geom type="capsule" size="0.03" fromto="0 0 0 0.3 0 0" mass="2"/><body name="l4" pos="0.3 0 0">
<joint name="j4" axis="1 0 0" armature="0.02"/><geom type="box" size="0.08 0.03 0.02" pos="0.05 0.02 0" mass="0.8"/>
</body></body></body></body></worldbody><actuator><motor name="m1" joint="j1"/><motor name="m2" joint="j2"/>
<motor name="m3" joint="j3"/><motor name="m4" joint="j4"/></actuator><sensor><jointpos name="q1" joint="j1"/>
<jointpos name="q2" joint="j2"/><jointpos name="q3" joint="j3"/><jointpos name="q4" joint="j4"/></sensor></mujoco>"""
PLANTED = {"dof_damping": (3.0, 0.0, 1.5, 0.0), "dof_frictionloss": (0.0, 4.0, 0.0, 0.5)}
"""What the real arm has and the model lacks, N m s/rad and N m, by joint."""
SPRING = (60.0, -0.3)
"""Stiffness, N m/rad, and rest position, rad, of a counterbalance at the second joint, where there is one."""
_RATE, _DURATION = 100.0, 6.0


def robot() -> Robot:
    """The nominal arm."""
    return Robot.from_string(NOMINAL, "arm")


@cache
def case(planted: bool, seed: int = 3, balanced: bool = False) -> Case:
    """Two training recordings and one to test, of an arm whose masses are 1 % off; `balanced`: by a spring, too."""
    nominal, rng = robot(), np.random.default_rng(seed)
    names = [("train", "a"), ("train", "b"), ("test", "c")]
    recordings = tuple(_recorded(rng, planted, balanced, f"{role}_{name}.csv", role) for role, name in names)
    return Case(nominal, recordings, (nominal,) * 3)


def _recorded(rng: np.random.Generator, planted: bool, balanced: bool, name: str, role: str) -> Recording:
    """Sines by a controller that knows the nominal arm; what it asks of the motors is logged."""
    real, known = mujoco.MjModel.from_xml_string(NOMINAL), mujoco.MjModel.from_xml_string(NOMINAL)
    real.opt.timestep /= 10.0
    real.body_mass[:] *= 1.0 + 0.01 * rng.choice([-1.0, 1.0], real.nbody)
    if planted:
        for field, values in PLANTED.items():
            getattr(real, field)[:] = values
    if balanced:
        real.jnt_stiffness[1], real.qpos_spring[1] = SPRING
    mujoco.mj_setConst(real, mujoco.MjData(real))
    rate, phase = rng.uniform(0.3, 0.9, (2, 4)), rng.uniform(0.0, 6.0, (2, 4))
    size = np.array([0.6, 0.4, 0.5, 0.7])

    def wanted(t: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        w = 2.0 * np.pi * rate
        s, c = np.sin(w * t + phase), np.cos(w * t + phase)
        return size * s.mean(axis=0), size * (w * c).mean(axis=0), -size * (w * w * s).mean(axis=0)

    data, plan = mujoco.MjData(real), mujoco.MjData(known)
    data.qpos[:], data.qvel[:], _ = wanted(0.0)
    rows = int(_DURATION * _RATE)
    time, ctrl, sensor = np.arange(rows) / _RATE, np.zeros((rows, 4)), np.zeros((rows, 4))
    for k in range(rows):
        q, v, a = wanted(time[k])
        plan.qpos[:], plan.qvel[:] = data.qpos, data.qvel
        plan.qacc[:] = a + 100.0 * (q - data.qpos) + 20.0 * (v - data.qvel)
        mujoco.mj_inverse(known, plan)
        ctrl[k], sensor[k] = plan.qfrc_inverse, data.qpos + 2e-4 * rng.standard_normal(4)
        data.ctrl[:] = ctrl[k]
        mujoco.mj_step(real, data, round(1.0 / _RATE / real.opt.timestep))
    nothing = np.full((rows, 4), np.nan)
    return Recording(name, time, ctrl, np.ones((rows, 4)), sensor, nothing, nothing.copy(), role=role)
