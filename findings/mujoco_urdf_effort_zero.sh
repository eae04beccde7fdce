#!/bin/sh
# mujoco 4.0.0: a URDF joint with effort="0" is loaded as one without any limit of torque.
#
# Guess: effort is the largest torque, so that 0 lets no motor move the joint, as it does in simulators that clip to it;
# or the file is refused. (URDF asks for the attribute; exporters write 0 where nobody filled it in.)
# Seen: effort="5" becomes actuatorfrcrange -5 .. 5; effort="0" becomes no limit at all, and a motor of 40 N m acts in
# full. `velocity` is dropped in both.
# Output seen:
#   effort 5: limited True, torque 5
#   effort 0: limited False, torque 40
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" -q install mujoco==4.0.0
"$place/venv/bin/python" - <<'PYTHON'
import mujoco

URDF = """<robot name="arm"><link name="base"/><link name="tip"><inertial><mass value="1"/><origin xyz="0 0 -.1"/>
<inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="j" type="revolute"><parent link="base"/><child link="tip"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="{effort}" velocity="2"/></joint></robot>"""


def torque(effort):
    spec = mujoco.MjSpec.from_string(URDF.format(effort=effort))
    motor = spec.add_actuator(name="m", trntype=mujoco.mjtTrn.mjTRN_JOINT, target="j")
    motor.set_to_motor()
    model = spec.compile()
    data = mujoco.MjData(model)
    data.ctrl[0] = 40.0
    mujoco.mj_forward(model, data)
    return bool(model.jnt_actfrclimited[0]), round(float(data.qfrc_actuator[0]), 6)


seen = {effort: torque(effort) for effort in (5, 0)}
for effort, (limited, force) in seen.items():
    print(f"effort {effort}: limited {limited}, torque {force:g}")
assert seen == {5: (True, 5.0), 0: (False, 40.0)}, seen
PYTHON
