"""Two small arms of two joints, one with position servos and one driven by torques, and two blocks on a floor."""

from __future__ import annotations

_ARM = """<mujoco model="{name}">
  <compiler angle="radian" autolimits="true"/>
  <option timestep="0.005" integrator="{integrator}"/>
  <default>
    <geom contype="0" conaffinity="0"/>
    <joint axis="0 1 0" damping="{damping}" armature="{armature}"/>
    {default}
  </default>
  <worldbody>
    <body name="post" pos="0 0 0.5">
      <geom type="box" size="0.03 0.03 0.03" mass="0.8"/>
      {imu}
      <body name="upper">
        <joint name="shoulder"/>
        <geom type="capsule" fromto="0 0 0 0 0 -0.25" size="0.02" mass="0.5"/>
        <body name="lower" pos="0 0 -0.25">
          <joint name="elbow"/>
          <geom type="capsule" fromto="0 0 0 0 0 -0.2" size="0.015" mass="0.3"/>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator>
    <{motor} name="upper_motor" joint="shoulder"/>
    <{motor} name="lower_motor" joint="elbow"/>
  </actuator>
  <sensor>
    <jointpos name="upper_angle" joint="shoulder"/>
    <jointpos name="lower_angle" joint="elbow"/>
    {gyro}
  </sensor>
</mujoco>
"""
_IMU, _GYRO = '<site name="imu"/>', '<gyro name="rate" site="imu"/>'
_BLOCK = """<mujoco model="{name}">
  <compiler angle="radian" autolimits="true"/>
  <option timestep="0.005" integrator="{integrator}"/>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1" friction="0.4 0.005 0.0001"/>
    <body name="block" pos="0 0 0.05">
      <joint name="along" type="slide" axis="1 0 0" damping="0.5"/>
      <joint name="up" type="slide" axis="0 0 1"/>
      <geom type="box" size="0.08 0.05 0.05" mass="1" friction="0.4 0.005 0.0001"/>
    </body>
  </worldbody>
  <actuator>{motor}</actuator>
  <sensor><jointpos name="place" joint="along"/><jointpos name="height" joint="up"/></sensor>
</mujoco>
"""
_SERVO = '<position kp="12" kv="0.4" forcerange="-4 4" ctrlrange="-1.2 1.2"/>'
_TORQUE = '<motor ctrlrange="-3 3"/>'


def _arm(name: str, *, servo: bool, gyro: bool) -> str:
    return _ARM.format(
        name=name,
        integrator="implicitfast" if servo else "Euler",
        damping=0.02 if servo else 0.05,
        armature=0.003 if servo else 0.004,
        default=_SERVO if servo else _TORQUE,
        motor="position" if servo else "motor",
        imu=_IMU if gyro else "",
        gyro=_GYRO if gyro else "",
    )


MODELS = {
    "servo": _arm("servo", servo=True, gyro=False),
    "torque": _arm("torque", servo=False, gyro=False),
    "servo_gyro": _arm("servo_gyro", servo=True, gyro=True),
    "torque_gyro": _arm("torque_gyro", servo=False, gyro=True),
    "servo_block": _BLOCK.format(
        name="servo_block",
        integrator="implicitfast",
        motor='<position name="push" joint="along" kp="60" kv="6" forcerange="-30 30" ctrlrange="-0.3 0.3"/>',
    ),
    "torque_block": _BLOCK.format(
        name="torque_block", integrator="Euler", motor='<motor name="push" joint="along" ctrlrange="-15 15"/>'
    ),
}
"""The nominal models by name."""
