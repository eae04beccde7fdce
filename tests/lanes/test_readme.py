"""The example of lanes' README runs with the modules that it names, and agrees with the C engine."""

import re
import subprocess
import sys
from importlib.resources import files

import mujoco
import numpy as np

README = (files("estexp_jax.lanes") / "README.md").read_text(encoding="utf-8")
LARGEST = 1e-4


def test_the_example_agrees_with_the_c_engine() -> None:
    (code,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    ran: dict = {"__name__": "example"}
    exec(compile(code, "lanes/README.md", "exec"), ran)  # noqa: S102 (our own page)
    model, touched = mujoco.MjModel.from_xml_string(ran["XML"]), 0
    model.opt.iterations, model.opt.tolerance = 100, 1e-12
    for robot in range(ran["N"]):
        model.body_mass[:] = ran["masses"][:, robot]
        data = mujoco.MjData(model)
        data.ctrl[:] = ran["ctrl"][:, robot]
        for _ in range(ran["STEPS"]):
            mujoco.mj_step(model, data)
            touched += data.ncon
        np.testing.assert_allclose(ran["qpos_after"][:, robot], data.qpos, atol=LARGEST)
        np.testing.assert_allclose(ran["qvel_after"][:, robot], data.qvel, atol=LARGEST, rtol=1e-3)
    assert touched > 0 and np.ptp(ran["qpos_after"][1]) > 0.1


def test_the_front_needs_nothing_else_of_the_package() -> None:
    code = """
import sys
from estexp_jax import lanes
assert "jax" not in sys.modules
assert all(getattr(lanes, name) is not None for name in lanes.__all__)
others = {m.split(".")[1] for m in sys.modules if m.startswith("estexp_jax.")} - {"lanes"}
print(*sorted(others))
"""
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == ""
