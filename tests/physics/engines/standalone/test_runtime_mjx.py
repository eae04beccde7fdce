"""On MJX, an `explained.py` does what it does over MuJoCo."""

import copy

import jax
import mujoco
import numpy as np
import pytest
from mujoco import mjx

from estexp_jax.physics.effects.changes import parse_change
from tests.physics.engines.standalone.standalone_case import by_script, commands, imported
from tests.physics.exported import robot_of

ROWS = 40
FOUND = (
    "stribeck_friction@elbow T=0.1 S=0.2 w_s=0.3",
    "hysteresis@shoulder T=0.1 sigma=3",
    "motor_fade@lift loss=0.5 tau=0.6",
    "gravity_compensation@shoulder share=0.5",
    "command_delay@bend delay=0.0051",
    "sensor_delay@bent delay=0.0051",
    "viscous_friction@elbow c=0.1",
)


@pytest.mark.slow
def test_mjx_steps_what_was_found(tmp_path):
    robot = robot_of("servos")
    module = imported(tmp_path, robot, [(parse_change(text, robot), False) for text in FOUND])
    ctrl, on = commands(robot, ROWS)
    ctrl = robot.home() + 0.1 * ctrl  # MJX brakes motors at their limits
    nominal = copy.copy(robot.model)
    nominal.opt.iterations, nominal.opt.tolerance = 50, 1e-12
    nominal.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    expected, readings = by_script(module, nominal, robot.home(), ctrl, np.ones_like(on))
    model, memory, step = module.mjx_simulation(nominal)
    with jax.enable_x64(True):
        mx, dx = mjx.put_model(model), mjx.make_data(model).replace(qpos=robot.home())
        memory = jax.tree.map(lambda x: x if x.dtype == bool else x.astype(float), memory)

        def run(carry, u):
            dx, memory = carry
            after, memory = step(mx, dx.replace(ctrl=u), memory)
            return (after, memory), (dx.qpos, after.sensordata)

        _, (qpos, seen) = jax.jit(lambda dx, memory: jax.lax.scan(run, (dx, memory), ctrl))(dx, memory)
    np.testing.assert_allclose(qpos, expected, atol=2e-5)
    np.testing.assert_allclose(seen, readings, atol=2e-3)
