"""Robots on which effects are ambiguous under one motion, and not under another."""

from __future__ import annotations

from collections.abc import Callable

import mujoco

from estexp_jax.package_data import model_path

Number = Callable[[float], float]
"""What becomes of a number of the model: itself in the nominal one, a little wrong in the real robot."""


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
