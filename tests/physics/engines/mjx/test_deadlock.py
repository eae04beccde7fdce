"""MJX's Newton solver on two cores of a CPU comes to an end, whatever the version of JAX.

With jaxlib 0.10.2 some runs stand still: a batched Cholesky, spread over the pool of threads, waits in a worker of that
pool for the others, and where two programs do so at once on two cores, no worker is left. Batches of 400 do it. The
jaxlib of JAX 0.9, 0.11 and 0.12 does not spread it.
"""

import os
import subprocess
import sys

import pytest

_PROGRAM = """
import jax, jax.numpy as jnp, mujoco
from estexp_jax.physics import quiet_mjx
from estexp_jax.package_data import model_path
from mujoco import mjx

model = mujoco.MjModel.from_xml_path(str(model_path("quadruped")))
model.opt.solver = mujoco.mjtSolver.mjSOL_NEWTON
put = mjx.put_model(model)
start = mjx.make_data(put)

def rolled(shift):
    data = start.replace(qpos=start.qpos.at[2].add(shift))
    def step(data, _):
        return mjx.step(put, data), None
    return jax.lax.scan(step, data, None, length=20)[0].qpos

many = jax.jit(jax.vmap(rolled))
for turn in range(3):  # dispatched one after the other, none waited for
    found = many(jnp.linspace(0.0, 0.1, 400) + 0.001 * turn)
print(bool(jnp.isfinite(found).all()))
"""


@pytest.mark.slow
def test_batches_of_four_hundred_end_on_two_cores():
    def two_cores() -> None:
        os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:2])

    command = [sys.executable, "-c", _PROGRAM]
    environment = {**os.environ, "JAX_PLATFORMS": "cpu"}
    done = subprocess.run(
        command, env=environment, capture_output=True, text=True, timeout=900, preexec_fn=two_cores, check=False
    )
    assert done.stdout.strip().endswith("True"), done.stderr[-2000:]
