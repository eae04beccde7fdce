#!/bin/sh
# pin (Pinocchio) 4.1.0 and mujoco 4.0.0: of one URDF with damping, friction and an effort limit, the one's forward
# dynamics have none of the three, though its model has read them all; the other's have damping and friction.
#
# Guess: pin.aba accelerates a joint as the model says that it loaded: model.damping .5, model.friction .2 and
# model.effortLimit 1 are there.
# Seen: at 1 rad/s under 5 N m, aba gives 250 rad/s2, the bare rigid body's (.02 kg m2), and rnea no torque at a steady
# speed. MuJoCo gives 215, less both frictions. A log of a robot that is simulated by one and explained by the other
# differs by what stands in the very file that both read.
# Output seen:
#   read by Pinocchio: damping 0.5, friction 0.2, effort 1
#   aba 250, rnea 0, mujoco 215
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" -q install pin==4.1.0 mujoco==4.0.0
"$place/venv/bin/python" - <<'PYTHON'
import mujoco
import numpy as np
import pinocchio as pin

URDF = """<robot name="arm"><link name="base"/><link name="tip"><inertial><mass value="1"/><origin xyz="0 0 -.1"/>
<inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="j" type="revolute"><parent link="base"/><child link="tip"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/><dynamics damping="0.5" friction="0.2"/></joint></robot>"""
model = pin.buildModelFromXML(URDF)
data, rest, speed = model.createData(), np.zeros(1), np.ones(1)
read = [float(x[0]) for x in (model.damping, model.friction, model.effortLimit)]
bare = float(pin.aba(model, data, rest, speed, np.array([5.0]))[0])
torque = float(pin.rnea(model, data, rest, speed, np.zeros(1))[0])
other = mujoco.MjModel.from_xml_string(URDF)
state = mujoco.MjData(other)
state.qvel[:], state.qfrc_applied[:] = 1.0, 5.0
mujoco.mj_forward(other, state)
print("read by Pinocchio: damping {:g}, friction {:g}, effort {:g}".format(*read))
print(f"aba {bare:g}, rnea {torque:g}, mujoco {state.qacc[0]:.6g}")
assert read == [0.5, 0.2, 1.0], read
assert abs(bare - 250.0) < 1e-6 and torque == 0.0 and abs(state.qacc[0] - 215.0) < 1e-3
PYTHON
