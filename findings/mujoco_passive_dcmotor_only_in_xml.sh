#!/bin/sh
# mujoco 4.0.0: a DC motor that only cogs can be written in XML, not by MjSpec's set_to_dcmotor.
#
# Guess: both doors take the same numbers.
# Seen: <dcmotor input="none" motorconst="0" resistance="1" cogging="0.2 7 0"/> loads, with no control, and turns the
# joint by A sin(n q + phase); set_to_dcmotor(motorconst=[0, 0], ...) refuses it: "motor constant K must be positive".
# Output seen:
#   XML: nu 0, torque 0.128844 at q = 0.1 (0.2 sin 0.7 = 0.128844)
#   set_to_dcmotor: DC motor: motor constant K must be positive
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" -q install mujoco==4.0.0
"$place/venv/bin/python" - <<'PYTHON'
import math

import mujoco

BODY = '<worldbody><body><joint name="j" axis="0 1 0"/><geom size=".1"/></body></worldbody>'
MOTOR = '<actuator><dcmotor joint="j" input="none" motorconst="0" resistance="1" cogging="0.2 7 0"/></actuator>'
model = mujoco.MjModel.from_xml_string(f"<mujoco>{BODY}{MOTOR}</mujoco>")
data = mujoco.MjData(model)
data.qpos[0] = 0.1
mujoco.mj_forward(model, data)
force = float(data.qfrc_passive[0] + data.qfrc_actuator[0])
print(f"XML: nu {model.nu}, torque {force:.6f} at q = 0.1 (0.2 sin 0.7 = {0.2 * math.sin(0.7):.6f})")
assert model.nu == 0 and abs(force - 0.2 * math.sin(0.7)) < 1e-9
spec = mujoco.MjSpec.from_string(f"<mujoco>{BODY}</mujoco>")
motor = spec.add_actuator(name="m", trntype=mujoco.mjtTrn.mjTRN_JOINT, target="j")
try:
    motor.set_to_dcmotor(motorconst=[0.0, 0.0], resistance=1.0, cogging=[0.2, 7.0, 0.0])
    said = "taken"
except Exception as error:
    said = str(error)
print(f"set_to_dcmotor: {said}")
assert said == "DC motor: motor constant K must be positive", said
PYTHON
