#!/bin/sh
# mujoco 4.0.0: an output of a batch that is bound after steps reads zeros until the next step; a state reads the present.
#
# Guess: `batch.bind("sensordata")` after ten steps shows the readings of the tenth, as `bind("qvel")` shows its speeds; or
# binding an output late is refused. Zeros are readings as good as any, so a log that begins so looks right.
# Seen: speeds are there, sensors and positions of bodies are zero; after one more step all of them are there. The
# docstring says that outputs are "copied out after every call", not what they hold before one.
# Output seen:
#   speed -0.1962, sensor 0, height of the body 0
#   after one more step: sensor -0.1962
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" -q install mujoco==4.0.0
"$place/venv/bin/python" - <<'PYTHON'
import mujoco
from mujoco.batch import Batch

model = mujoco.MjModel.from_xml_string("""<mujoco><worldbody><body name="b"><joint name="j" type="slide" axis="0 0 1"/>
<geom size=".1"/></body></worldbody><sensor><jointvel joint="j"/></sensor></mujoco>""")
batch = Batch(model, 1, nthread=1)
for _ in range(10):
    batch.step()
speed, sensor, place = (batch.bind(name) for name in ("qvel", "sensordata", "xpos"))
late = round(float(speed[0, 0]), 6), float(sensor[0, 0]), float(place[0].reshape(-1, 3)[1, 2])
print(f"speed {late[0]:g}, sensor {late[1]:g}, height of the body {late[2]:g}")
batch.step()
print(f"after one more step: sensor {float(sensor[0, 0]):g}")
assert late == (-0.1962, 0.0, 0.0) and round(float(sensor[0, 0]), 6) == -0.1962
PYTHON
