"""Small robots, each with something the quadruped has not, and the quadruped itself."""

from functools import cache

from estexp_jax.package_data import model_path
from estexp_jax.physics.model.robot import Robot

# Fixed base, servo with gear and force range, an undriven elbow with a spring, a tilted inertia, an accelerometer.
PENDULUM = """
<mujoco model="pendulum">
  <compiler angle="radian" autolimits="true"/>
  <option timestep="0.005"/>
  <worldbody>
    <body name="arm" pos="0 0 1">
      <joint name="shoulder" axis="0 1 0" damping="0.05" armature="0.002"/>
      <inertial pos="0.01 0 -0.1" euler="0.3 0.2 0.1" mass="0.6" diaginertia="0.004 0.003 0.002"/>
      <body name="hand" pos="0 0 -0.25">
        <joint name="elbow" axis="0 1 0" damping="0.01" stiffness="0.2" range="-2 2"/>
        <geom type="capsule" fromto="0 0 0 0 0 -0.2" size="0.02" mass="0.2" contype="0" conaffinity="0"/>
        <site name="tip" pos="0 0 -0.2"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position name="servo" joint="shoulder" kp="3" kv="0.05" gear="2" ctrlrange="-3 3" forcerange="-1.5 1.5"/>
  </actuator>
  <sensor>
    <jointpos name="angle" joint="shoulder"/>
    <jointvel name="speed" joint="elbow"/>
    <actuatorfrc name="effort" actuator="servo"/>
    <accelerometer name="acc" site="tip"/>
  </sensor>
</mujoco>
"""

# A cart that slides along a turned rail, with home keyframe, native friction, geared motor, and a swinging pole.
CARTPOLE = """
<mujoco model="cartpole">
  <compiler angle="radian" autolimits="true"/>
  <option timestep="0.005"/>
  <worldbody>
    <body name="cart" pos="0.1 0 0.5" euler="0 0 1.5707963267948966">
      <joint name="rail" type="slide" axis="0 1 0" range="-2 2" damping="0.2" frictionloss="0.3"/>
      <geom type="box" size="0.1 0.05 0.05" mass="1" contype="0" conaffinity="0"/>
      <body name="pole">
        <joint name="swing" axis="0 0 1" damping="0.02" armature="0.02"/>
        <joint name="pivot" axis="1 0 0" damping="0.01"/>
        <geom type="capsule" fromto="0 0 0 0 0 0.5" size="0.02" mass="0.2" contype="0" conaffinity="0"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <motor name="push" joint="rail" gear="10" ctrlrange="-1 2" forcerange="-0.5 0.5"/>
    <position name="aim" joint="swing" kp="0.5" ctrlrange="-1 1"/>
  </actuator>
  <sensor>
    <jointpos name="place" joint="rail"/>
    <jointpos name="lean" joint="pivot"/>
    <framepos name="where" objtype="body" objname="pole"/>
  </sensor>
  <keyframe><key name="home" qpos="0.3 0.2 0.1"/></keyframe>
</mujoco>
"""

# MJX's implicitfast takes a clipped motor's damping for active, so none has a force range here.
# Named are only the joints that motors drive; branches on a ball joint, an undriven slide, two motors on one joint.
NAMELESS = """
<mujoco>
  <compiler angle="radian" autolimits="true"/>
  <option timestep="0.004" integrator="implicitfast"/>
  <worldbody>
    <body pos="0 0 1">
      <joint type="ball" damping="0.02"/>
      <geom type="box" size="0.05 0.06 0.07" mass="0.5" pos="0.02 0 -0.1" contype="0" conaffinity="0"/>
      <body pos="0.1 0 -0.1">
        <joint name="left" axis="0 1 0" damping="0.03" armature="0.001"/>
        <geom type="capsule" fromto="0 0 0 0.2 0 0" size="0.02" mass="0.3" contype="0" conaffinity="0"/>
        <body pos="0.2 0 0">
          <joint type="slide" axis="1 0 0" damping="0.5" range="-0.1 0.1"/>
          <geom type="sphere" size="0.03" mass="0.1" contype="0" conaffinity="0"/>
        </body>
      </body>
      <body pos="-0.1 0 -0.1">
        <joint name="right" axis="0 1 0" damping="0.04" frictionloss="0.01"/>
        <geom type="capsule" fromto="0 0 0 -0.2 0 0" size="0.02" mass="0.3" contype="0" conaffinity="0"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <general joint="left" gear="1.5" gainprm="2" biastype="affine" biasprm="0.1 -3 -0.02"/>
    <velocity joint="left" kv="0.3" ctrlrange="-2 2"/>
    <position joint="right" kp="2" dampratio="0.5" ctrlrange="-1 1"/>
  </actuator>
  <sensor>
    <jointpos joint="left"/>
    <jointpos joint="right"/>
  </sensor>
</mujoco>
"""

# A mass on two slides that carries nothing, with rotor inertia: MuJoCo's constants take a short cut for it.
SLIDER = """
<mujoco model="slider">
  <compiler autolimits="true"/>
  <option timestep="0.005"/>
  <worldbody>
    <body name="sled" pos="0 0 1">
      <joint name="along" type="slide" axis="1 0 0" armature="0.5" damping="0.3" range="-0.05 0.05"/>
      <joint name="across" type="slide" axis="0 1 0" damping="0.3"/>
      <geom size="0.1" mass="2"/>
    </body>
  </worldbody>
  <actuator>
    <motor name="push" joint="along" gear="20"/>
    <motor name="drift" joint="across" gear="5"/>
  </actuator>
</mujoco>
"""

# No sensor, no motor, nothing that could come off: effects have to cope with having no place.
MUTE_XML = """
<mujoco model="mute">
  <worldbody>
    <body name="bob"><joint name="pin" axis="0 1 0"/><geom size="0.1" pos="0 0 -0.3" mass="1"/></body>
  </worldbody>
</mujoco>
"""

# A pedestal that the model welds to the world, with an arm on it.
BOLTED_XML = """
<mujoco model="bolted">
  <worldbody>
    <body name="pedestal" pos="0 0 0.5"><geom type="box" size="0.1 0.1 0.5" mass="20"/>
      <body name="arm" pos="0 0 0.6"><joint name="pitch" axis="0 1 0" damping="0.1"/>
        <geom type="capsule" size="0.03" fromto="0 0 0 0.4 0 0" mass="1"/></body>
    </body>
  </worldbody>
  <actuator><motor name="drive" joint="pitch"/></actuator>
  <sensor><jointpos name="angle" joint="pitch"/></sensor>
</mujoco>
"""

MUTE, BOLTED = "mute", "bolted"
ROBOTS = ("quadruped", "pendulum", "cartpole", "nameless")


@cache
def robot(name: str) -> Robot:
    """One of `ROBOTS`, `mute`, `bolted` or `slider`, compiled once."""
    if name == "quadruped":
        return Robot.from_xml(model_path("quadruped"))
    texts = {"pendulum": PENDULUM, "cartpole": CARTPOLE, "nameless": NAMELESS, "slider": SLIDER}
    texts |= {MUTE: MUTE_XML, BOLTED: BOLTED_XML}
    return Robot.from_string(texts[name], f"{name}.xml")
