"""`explained.py` simulates what this package's own simulator does, and needs nothing of it."""

import mujoco
import numpy as np
import pytest

from estexp_jax.discovery.export import explained_spec
from estexp_jax.physics.effects.changes import parse_change
from estexp_jax.physics.model.actuators import HAS_DECLARED_INPUTS
from tests.physics.engines.standalone.standalone_case import by_batch, by_engine, by_script, commands, imported
from tests.physics.exported import robot_of

ROWS = 60
PLANTED = {
    "what acts during a step": (
        "stribeck_friction@elbow T=0.1 S=0.2 w_s=0.3",
        "supply_sag R=0.05",
        "motor_fade@lift loss=0.5 tau=0.6",
        "crosstalk@elbow from=shoulder g=0.1",
        "gravity_compensation@shoulder share=0.5",
        "command_limit@bend v=4 a=60",
        "external_force@lower x=1 y=0 z=0 k=2",
    ),
    "what remembers": ("hysteresis@elbow T=0.1 sigma=3", "joint_compliance@shoulder k=60 d=0.2 I=0.01"),
    "play": ("backlash@elbow half_gap=0.03",),
    "what is late": (
        "command_delay@lift delay=0.0073",
        "sensor_delay@bent delay=0.0051",
        "sensor_gain@high gain=1.1",
        "sensor_bias@speed bias=0.2",
    ),
    "values of the model": ("motor_weakness@lift loss=0.3", "viscous_friction@elbow c=0.1", "body_mass@lower dm=0.1"),
    "limits": ("joint_limit@elbow low=0.2 high=0.6", "tied_outputs@bend with=lift"),
}


@pytest.mark.parametrize("name", PLANTED)
def test_it_simulates_what_the_engine_does(name, tmp_path):
    robot = robot_of("servos")
    changes = [parse_change(text, robot) for text in PLANTED[name]]
    ctrl, on = commands(robot, ROWS)
    expected = by_engine(robot, changes, ctrl, on)
    module = imported(tmp_path, robot, [(c, False) for c in changes])
    ways = (by_script, by_batch) if HAS_DECLARED_INPUTS else (by_script,)
    for qpos, readings in (f(module, robot.model, robot.home(), ctrl, on) for f in ways):
        np.testing.assert_allclose(qpos, expected.qpos[0], atol=1e-6)
        # The engine reads the last row without a step, so that its last velocities are those of another row.
        np.testing.assert_allclose(readings[:-1], expected.sensors[0][:-1], atol=1e-6)


def test_it_takes_the_finer_steps_of_the_simulator(tmp_path):
    robot = robot_of("servos")
    changes = [parse_change("stribeck_friction@elbow T=0.1 S=0.2 w_s=0.3", robot)]
    ctrl, on = commands(robot, ROWS)
    module = imported(tmp_path, robot, [(c, False) for c in changes], finer=4)
    qpos, _ = by_script(module, robot.model, robot.home(), ctrl, on)
    np.testing.assert_allclose(qpos, by_engine(robot, changes, ctrl, on, 4).qpos[0], atol=1e-6)


def test_over_the_file_it_adds_what_that_lacks(tmp_path):
    robot = robot_of("servos")
    native = parse_change("coulomb_friction@elbow T=0.2", robot)
    other = parse_change("supply_sag R=0.05", robot)
    file = explained_spec(robot, [native]).compile()
    module = imported(tmp_path, robot, [(native, True), (other, False)], file=file)
    ctrl, on = commands(robot, ROWS)
    expected = by_engine(robot, [native, other], ctrl, on).qpos[0]
    for model in (robot.model, file):
        np.testing.assert_allclose(by_script(module, model, robot.home(), ctrl, on)[0], expected, atol=1e-6)
    alone, _ = by_script(imported(tmp_path, robot, []), file, robot.home(), ctrl, on)
    assert np.abs(alone - expected).max() > 1e-3


def test_it_says_what_was_found_in_words(tmp_path):
    robot = robot_of("servos")
    text = imported(tmp_path, robot, [(parse_change("dead_band@bend half_width=0.05", robot), False)]).__doc__
    assert "- the motor bend ignores" in text and "(not in model_explained.xml)" in text


def test_installed_again_it_forgets_and_edits_nothing_twice(tmp_path):
    robot = robot_of("servos")
    module = imported(tmp_path, robot, [(parse_change("viscous_friction@elbow c=0.1", robot), False)])
    model = robot.spec.copy().compile()
    data, other = mujoco.MjData(model), mujoco.MjData(model)
    for one in (data, data, other):
        module.install(model, one)
    assert model.dof_damping[1] == pytest.approx(robot.model.dof_damping[1] + 0.1)
