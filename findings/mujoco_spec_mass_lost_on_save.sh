#!/bin/sh
# mujoco 4.0.0: MjSpec.to_xml loses the inertia of a body whose centre of mass is at its origin.
#
# Guess: a body that is given mass and inertia in Python (explicitinertial) comes back from to_xml with them.
# Seen: 7 kg and .1 kg m2 in the compiled model. The saved text has no <inertial>, since `ipos` was left at its default,
# and loads without a word with what the geom's density makes of it: 4.189 kg, .01676 kg m2. With
# compiler.savecompiled = False there is an <inertial> without `pos`, which MuJoCo refuses to read:
# "required attribute missing: 'pos'". With ipos a millimetre off the origin both texts are right.
# Output seen:
#   saved as compiled: 7.0 kg -> 4.189 kg
#   saved as specified: 7.0 kg -> refused: required attribute missing: 'pos'
#   off the origin: 7.0 kg -> 7 kg
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" -q install mujoco==4.0.0
"$place/venv/bin/python" - <<'PYTHON'
import mujoco


def saved(compiled, ipos=None):
    spec = mujoco.MjSpec()
    spec.compiler.savecompiled = compiled
    given = {} if ipos is None else {"ipos": ipos}
    body = spec.worldbody.add_body(name="b", mass=7.0, inertia=[0.1] * 3, explicitinertial=True, **given)
    body.add_joint(name="j")
    body.add_geom(size=[0.1, 0.0, 0.0])
    before = spec.compile().body_mass[1]
    try:
        after = f"{mujoco.MjModel.from_xml_string(spec.to_xml()).body_mass[1]:.4g} kg"
    except ValueError as error:
        after = "refused: " + str(error).splitlines()[0].removeprefix("XML Error: ")
    return f"{before:.1f} kg -> {after}"


seen = [saved(True), saved(False), saved(True, [0.0, 0.0, 1e-3])]
for what, line in zip(("saved as compiled", "saved as specified", "off the origin"), seen):
    print(f"{what}: {line}")
assert seen[0] == "7.0 kg -> 4.189 kg", seen
assert seen[1] == "7.0 kg -> refused: required attribute missing: 'pos'", seen
assert seen[2] == "7.0 kg -> 7 kg", seen
PYTHON
