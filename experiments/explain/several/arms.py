"""Arms of hinge joints: their nominal models, drawn in length, mass and gearing, and their motions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import mujoco
import numpy as np

STEP, RATE = 0.005, 100.0
"""The nominal model's step, s, and rows a second."""
HELD = 0.5
"""How long an arm is held still before its recording begins, s."""
_AXES = {2: "yy", 3: "zyy", 6: "zyyxyx"}
_UNIT = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}
_MASS = {2: (3.0, 1.5), 3: (4.0, 3.0, 1.5), 6: (4.0, 3.5, 2.0, 1.0, 0.8, 0.4)}
_LENGTH = {2: (0.35, 0.3), 3: (0.25, 0.35, 0.3), 6: (0.25, 0.35, 0.2, 0.15, 0.1, 0.08)}
_ROTOR = 0.06
"""Inertia, kg m2, that even a light link's rotor is chosen for: geared wrists turn mostly their own rotors."""
_BANDWIDTH, _DAMPED = 25.0, 0.7
"""Of servos: their natural frequency, rad/s, and damping ratio."""
_STRONGEST = 4.0
"""Largest torque of a motor, in largest torques of the motion."""


@final
@dataclass(frozen=True, eq=False)
class Arm:
    """An arm as its maker describes it.

    Attributes:
        xml: its MJCF.
        model: the same, loaded.
        servo: whether its motors are servos.
        torque: (joints,) typical torque of its motions, N m (root mean square).
        speed: (joints,) typical speed, rad/s.
        inertia: (joints,) that a motor turns at home, rotor included, kg m2.
    """

    xml: str
    model: mujoco.MjModel
    servo: bool
    torque: np.ndarray
    speed: np.ndarray
    inertia: np.ndarray

    @property
    def joints(self) -> int:
        """How many it has."""
        return self.model.nu


@final
@dataclass(frozen=True, eq=False)
class Motion:
    """What an arm is to do: arrays (rows, joints) of positions, speeds and accelerations, held still at first."""

    position: np.ndarray
    speed: np.ndarray
    acceleration: np.ndarray


def drawn_arm(joints: int, servo: bool, friction_at: int | None, rng: np.random.Generator) -> Arm:
    """Draw an arm.

    Args:
        joints: 2, 3 or 6.
        servo: driven by position servos.
        friction_at: a joint whose friction the maker knows on average; None: there is none.
        rng: what decides.
    """
    lengths = np.array(_LENGTH[joints]) * rng.uniform(0.8, 1.25, joints)
    masses = np.array(_MASS[joints]) * rng.uniform(0.7, 1.4, joints)
    bare = mujoco.MjModel.from_xml_string(_xml(lengths, masses, np.zeros(joints), "motor", [""] * joints, {}))
    geared = rng.uniform(0.25, 0.6, joints) * (_inertia(bare) + _ROTOR)
    heavy = mujoco.MjModel.from_xml_string(_xml(lengths, masses, geared, "motor", [""] * joints, {}))
    inertia, motion = _inertia(heavy), drawn_motion(joints, 20.0, np.random.default_rng(0))
    torques = _inverse(heavy, motion)
    torque, peak = np.sqrt(np.mean(torques**2, axis=0)), _STRONGEST * np.abs(torques).max(axis=0)
    if servo:
        stiff, damp = inertia * _BANDWIDTH**2, 2.0 * _DAMPED * inertia * _BANDWIDTH
        drives = [
            f'kp="{k:.5g}" kv="{d:.5g}" forcerange="{-p:.4g} {p:.4g}"'
            for k, d, p in zip(stiff, damp, peak, strict=True)
        ]
    else:
        drives = [f'ctrllimited="true" ctrlrange="{-p:.4g} {p:.4g}"' for p in peak]
    friction = {} if friction_at is None else {friction_at: float(torque[friction_at] * rng.uniform(0.08, 0.15))}
    xml = _xml(lengths, masses, geared, "position" if servo else "motor", drives, friction)
    speed = np.sqrt(np.mean(motion.speed**2, axis=0))
    return Arm(xml, mujoco.MjModel.from_xml_string(xml), servo, torque, speed, inertia)


def _xml(
    lengths: np.ndarray,
    masses: np.ndarray,
    geared: np.ndarray,
    motor: str,
    drives: list[str],
    friction: dict[int, float],
) -> str:
    joints, axes = len(lengths), _AXES[len(lengths)]
    bodies, begin = "", "0 0 0.1"
    for j, axis in enumerate(axes):
        way = (0.0, 0.0, lengths[j]) if axis == "z" else (lengths[j], 0.0, 0.0)
        end = " ".join(f"{x:.4f}" for x in way)
        rubs = f' frictionloss="{friction[j]:.4g}"' if j in friction else ""
        bodies += f"""<body name="link{j + 1}" pos="{begin}"><joint name="j{j + 1}" axis="{_UNIT[axis]}"
  armature="{geared[j]:.5g}"{rubs}/><geom type="capsule" size="0.03" fromto="0 0 0 {end}" mass="{masses[j]:.4f}"/>
"""
        begin = end
    motors = "".join(f'<{motor} name="m{j + 1}" joint="j{j + 1}" {drives[j]}/>\n' for j in range(joints))
    sensors = "".join(f'<jointpos name="q{j + 1}" joint="j{j + 1}"/>\n' for j in range(joints))
    return f"""<mujoco model="arm{joints}"><compiler angle="radian"/>
<option timestep="{STEP}" integrator="implicitfast"><flag contact="disable"/></option>
<worldbody><body name="base"><geom type="cylinder" size="0.1 0.05" pos="0 0 0.05" mass="6"/>
{bodies}{"</body>" * joints}</body></worldbody>
<actuator>{motors}</actuator>
<sensor>{sensors}</sensor></mujoco>
"""


def _inertia(model: mujoco.MjModel) -> np.ndarray:
    """(joints,) diagonal of the mass matrix at home."""
    data, full = mujoco.MjData(model), np.zeros((model.nv, model.nv))
    mujoco.mj_forward(model, data)
    mujoco.mj_fullM(model, data, full)
    return full.diagonal().copy()


def _inverse(model: mujoco.MjModel, motion: Motion) -> np.ndarray:
    """(rows, joints) torques that a motion takes."""
    data, found = mujoco.MjData(model), np.zeros_like(motion.position)
    for k in range(len(found)):
        data.qpos[:], data.qvel[:], data.qacc[:] = motion.position[k], motion.speed[k], motion.acceleration[k]
        mujoco.mj_inverse(model, data)
        found[k] = data.qfrc_inverse
    return found


def home(joints: int) -> np.ndarray:
    """(joints,) the bent pose about which arms move, rad."""
    return np.where(np.arange(joints) % 2, 0.5, -0.4)


def drawn_motion(joints: int, duration: float, rng: np.random.Generator) -> Motion:
    """Three sines at each joint that swell from rest within a second, about a bent pose."""
    held = round(HELD * RATE)
    time = (np.arange(held + round(duration * RATE)) - held) / RATE
    swell = np.sin(0.5 * np.pi * np.clip(time, 0.0, 1.0)) ** 2
    hertz, phase = rng.uniform(0.2, 1.0, (3, joints)), rng.uniform(0.0, 2.0 * np.pi, (3, joints))
    sines = np.sin(2.0 * np.pi * hertz * time[:, None, None] + phase).mean(axis=1)
    position = home(joints) + swell[:, None] * rng.uniform(0.8, 1.3, joints) * sines
    speed = np.gradient(position, 1.0 / RATE, axis=0)
    return Motion(position, speed, np.gradient(speed, 1.0 / RATE, axis=0))
