"""Two or three effects that a first motion cannot tell apart, on robots where another motion can."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import final

import mujoco
import numpy as np

from estexp_jax.package_data import model_path

Number = Callable[[float], float]
"""What becomes of a number of the model: itself in the nominal one, a little wrong in the real robot."""
Motion = Callable[[np.ndarray, np.random.Generator], np.ndarray]
"""Times (rows,) and a source of chance to commands (rows, actuators)."""


@final
@dataclass(frozen=True)
class Ambiguity:
    """An ambiguity.

    Attributes:
        name: in words.
        robot: its MJCF, of what becomes of numbers.
        effects: each with its parameters at a strength in 0..1, as `estexp record --effect` takes it.
        motion: the first one, under which they say the same.
        equals: names that say the same as one of them on this robot, whatever its commands.
        noise: deviation of the noise on angles, rad: so much that what the first motion shows of the difference drowns.
        rest: for which the robot stands before a recording begins, s.
    """

    name: str
    robot: Callable[[Number], str]
    effects: tuple[Callable[[float], str], ...]
    motion: Motion
    equals: Mapping[str, str] = field(default_factory=dict)
    noise: float = 8e-3
    rest: float = 0.0

    @property
    def names(self) -> tuple[str, ...]:
        """Of the effects."""
        return tuple(effect(0.5).split()[0].partition("@")[0] for effect in self.effects)

    def said(self, effects: Iterable[str]) -> tuple[str, ...]:
        """Those of the ambiguity that some effects are, or say."""
        meant = {self.equals.get(name, name) for name in effects}
        return tuple(name for name in self.names if name in meant)


def motor(n: Number) -> str:
    """A pendulum that a motor turns by its torque; 0.44 N m hold it level."""
    return _pendulum("0 1 0", n, '<motor name="motor" joint="hinge" ctrlrange="-1 1"/>')


def hanging(n: Number) -> str:
    """A pendulum that a soft servo turns."""
    return _pendulum(
        "0 1 0", n, f'<position name="servo" joint="hinge" kp="{n(4.0):.9g}" kv="0.1" ctrlrange="-1.6 1.6"/>'
    )


def level(n: Number) -> str:
    """An arm that a servo turns about a vertical axis, where gravity does nothing."""
    return _pendulum(
        "0 0 1", n, f'<position name="servo" joint="hinge" kp="{n(4.0):.9g}" kv="0.1" ctrlrange="-1.6 1.6"/>'
    )


def turning(n: Number) -> str:
    """The pendulum with the soft servo, on a base that turns about a vertical axis."""
    return f"""
<mujoco>
  <option timestep="0.0025" integrator="implicitfast"/>
  <worldbody><body name="base">
    <joint name="pan" axis="0 0 1" damping="{n(0.1):.9g}" armature="{n(0.02):.9g}"/>
    <geom type="cylinder" size="0.05 0.03" mass="{n(0.5):.9g}" contype="0" conaffinity="0"/>
    {_arm("0 1 0", n)}
  </body></worldbody>
  <actuator>
    <position name="pan_servo" joint="pan" kp="{n(8.0):.9g}" kv="0.5" ctrlrange="-1.6 1.6"/>
    <position name="servo" joint="hinge" kp="{n(4.0):.9g}" kv="0.1" ctrlrange="-1.6 1.6"/>
  </actuator>
  <sensor><jointpos name="pan_angle" joint="pan"/><jointpos name="angle" joint="hinge"/></sensor>
</mujoco>"""


def _pendulum(axis: str, n: Number, actuator: str) -> str:
    return f"""
<mujoco>
  <option timestep="0.0025" integrator="implicitfast"/>
  <worldbody>{_arm(axis, n)}</worldbody>
  <actuator>{actuator}</actuator>
  <sensor><jointpos name="angle" joint="hinge"/></sensor>
</mujoco>"""


def _arm(axis: str, n: Number) -> str:
    along = "0 0 -0.3" if axis == "0 1 0" else "0.3 0 0"
    return f"""<body name="arm">
      <joint name="hinge" axis="{axis}" damping="{n(0.015):.9g}" armature="{n(0.004):.9g}"/>
      <geom type="capsule" fromto="0 0 0 {along}" size="0.02" mass="{n(0.3):.9g}" contype="0" conaffinity="0"/>
    </body>"""


def standing(n: Number) -> str:
    """The quadruped of Bongard and Lipson, with angle sensors in all joints and none in its feet."""
    spec = mujoco.MjSpec.from_file(str(model_path("quadruped")))
    for geom in spec.geoms:
        if geom.mass > 0.0:
            geom.mass = n(geom.mass)
    for joint in spec.joints:
        joint.damping, joint.armature = joint.damping * n(1.0), n(joint.armature)
    for servo in spec.actuators:
        servo.gainprm[0] = n(servo.gainprm[0])
        servo.biasprm[1] = -servo.gainprm[0]
    for sensor in list(spec.sensors):
        spec.delete(sensor)
    for joint in spec.joints[1:]:
        spec.add_sensor(
            name=f"{joint.name}_angle",
            type=mujoco.mjtSensor.mjSENS_JOINTPOS,
            objtype=mujoco.mjtObj.mjOBJ_JOINT,
            objname=joint.name,
        )
    return spec.to_xml()


_BEGIN = 2.5
"""Time in which slow motions begin, s: a jolt would tell more."""


def slow(size: float, joints: int = 1, at: int = 0) -> Motion:
    """Three slow sines at one actuator of several; the others rest."""

    def commands(time: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        f, p = rng.uniform(0.06, 0.16, 3), rng.uniform(0.0, 2.0 * np.pi, 3)
        found = np.zeros((len(time), joints))
        begun = np.clip(time / _BEGIN, 0.0, 1.0)
        whole = size / 1.8 * np.sin(2.0 * np.pi * f * time[:, None] + p).sum(axis=1)
        found[:, at] = begun**2 * (3.0 - 2.0 * begun) * whole
        return found

    return commands


def one_way(speed: float) -> Motion:
    """Away from home at about one speed, this way or that, without turning back."""

    def commands(time: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        way = speed * rng.uniform(0.9, 1.0) * (1.0 - 2.0 * int(rng.integers(2)))
        return way * time[:, None]

    return commands


def either_way(size: float) -> Motion:
    """All of a torque, one way or the other, for 0.5 to 1.5 s each."""

    def commands(time: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        turns = np.searchsorted(np.cumsum(rng.uniform(0.5, 1.5, 40)), time)
        return size * (1.0 - 2.0 * ((turns + int(rng.integers(2))) % 2))[:, None]

    return commands


AMBIGUITIES = (
    Ambiguity(
        "payload or weak motor",
        motor,
        (
            lambda s: f"body_mass@arm dm={0.3 * (1.0 + 0.4 * s):.6g}",
            lambda s: f"motor_weakness@motor loss={0.52 + 0.08 * s:.6g}",
        ),
        slow(0.07),
    ),
    Ambiguity(
        "delay or viscous friction",
        level,
        (
            lambda s: f"command_delay@servo delay={0.06 + 0.04 * s:.6g}",
            lambda s: f"viscous_friction@hinge c={0.24 + 0.16 * s:.6g}",
        ),
        slow(0.5),
        {"sensor_delay": "command_delay", "back_emf": "viscous_friction"},
    ),
    Ambiguity(
        "backlash, delay or stiction",
        level,
        (
            lambda s: f"backlash@hinge half_gap={0.014 + 0.008 * s:.6g}",
            lambda s: f"command_delay@servo delay={0.08 + 0.04 * s:.6g}",
            lambda s: f"coulomb_friction@hinge T={0.056 + 0.032 * s:.6g}",
        ),
        one_way(0.18),
        {"sensor_delay": "command_delay"},
    ),
    Ambiguity(
        "sensor gain or payload",
        hanging,
        (
            lambda s: f"sensor_gain@angle gain={0.8 - 0.06 * s:.6g}",
            lambda s: f"body_mass@arm dm={0.3 * (2.2 + 0.8 * s):.6g}",
        ),
        slow(0.3),
    ),
    Ambiguity(
        "joint offset or sensor bias",
        hanging,
        (
            lambda s: f"joint_offset@hinge offset={0.3 + 0.1 * s:.6g}",
            lambda s: f"sensor_bias@angle bias={-0.03 - 0.01 * s:.6g}",
        ),
        slow(0.25),
        {"gravity_tilt": "joint_offset"},
    ),
    Ambiguity(
        "saturation or weak motor",
        motor,
        (
            lambda s: f"torque_saturation@motor limit={0.3 * (0.48 - 0.1 * s):.6g}",
            lambda s: f"motor_weakness@motor loss={0.4 + 0.15 * s:.6g}",
        ),
        either_way(0.3),
        noise=2e-3,
    ),
    Ambiguity(
        "tilt or centre of mass",
        turning,
        (
            lambda s: f"gravity_tilt angle={0.2 + 0.1 * s:.6g} axis={np.pi / 2:.9g}",
            lambda s: f"com_shift@arm x={-0.03 - 0.015 * s:.6g}",
        ),
        slow(0.3, joints=2, at=1),
        {"joint_offset": "com_shift"},
        noise=2e-3,
    ),
    Ambiguity(
        "quadruped: payload or weak motors",
        standing,
        (
            lambda s: f"body_mass@torso dm={2.0 + 0.5 * s:.6g}",
            lambda s: f"motor_weakness@* loss={0.38 + 0.05 * s:.6g}",
        ),
        slow(0.2, joints=8),
        rest=2.0,
    ),
)
