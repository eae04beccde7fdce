"""Delays are as long as the model says, whatever the step, and begin with what was commanded before a window."""

import mujoco
import numpy as np
import pytest

from estexp_jax.physics.effects.changes import encode, stack
from estexp_jax.physics.effects.registry import catalogue
from estexp_jax.physics.engines.choice import open_loop_simulator
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.physics.window import InitialState, window_of
from estexp_jax.recordings.settings import apply_settings

ARM = """
<mujoco><option timestep="0.002"/><worldbody><body><joint name="j" axis="0 1 0" damping=".1"/>
<geom type="capsule" size=".03" fromto="0 0 0 .3 0 0" mass=".5"/></body></worldbody>
<actuator><motor name="a" joint="j" {}/></actuator><sensor><jointpos name="s" joint="j" {}/></sensor></mujoco>
"""
EFFECTS, ROWS = catalogue(["body_mass"]), 100
TIME = 0.004 * np.arange(ROWS)
COMMANDS = np.repeat(np.random.default_rng(0).uniform(-1.0, 1.0, (ROWS // 5, 1)), 5, axis=0)


def replayed(one: Robot, finer: int, rows: tuple[int, int], start: InitialState) -> tuple[np.ndarray, np.ndarray]:
    nothing = np.full((ROWS, 1), np.nan)
    recording = Recording("r.csv", TIME, COMMANDS, np.ones((ROWS, 1)), nothing, nothing, nothing)
    window = window_of([recording], 0, rows, 0.002 / finer, start)
    simulator = open_loop_simulator(one, EFFECTS, [one], engine="c")
    found = simulator.replay(stack([encode(one, EFFECTS, [])]), [window], np.zeros(1, int))
    return found.sensors[0, :, 0], found.qpos[0, :, 0]


def plain(one: Robot) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    model, data = one.model, mujoco.MjData(one.model)
    if model.actuator_history[0, 0]:
        mujoco.mj_initCtrlHistory(model, data, 0, 0.002 * np.arange(-5, 0), np.full(5, COMMANDS[0, 0]))
    rows = []
    for command in COMMANDS:
        mujoco.mj_forward(model, data)
        rows.append((data.sensordata[0], data.qpos[0], data.qvel[0]))
        data.ctrl[:] = command
        mujoco.mj_step(model, data, 2)
    sensor, qpos, qvel = np.array(rows).T
    return sensor, qpos, qvel


@pytest.mark.parametrize(
    ("actuator", "sensor"),
    [
        ('delay=".01" nsample="5"', ""),
        ('delay=".01" nsample="5" interp="linear"', ""),
        ("", 'delay=".01" nsample="5"'),
        ("", 'nsample="5" interval=".006"'),
    ],
)
def test_delays_do_not_depend_on_the_step(actuator: str, sensor: str) -> None:
    one, still = Robot.from_string(ARM.format(actuator, sensor)), InitialState(np.zeros(1), np.zeros(1))
    expected, without = plain(one), Robot.from_string(ARM.format("", ""))
    for finer in (1, 2, 4):
        readings, places = replayed(one, finer, (0, ROWS - 1), still)
        own = np.abs(replayed(without, finer, (0, ROWS - 1), still)[1] - plain(without)[1]).max()  # of the step itself
        assert np.abs(places - expected[1]).max() <= 1.2 * own + 1e-9
        assert np.abs(readings - expected[0]).max() <= 1.2 * own + 1e-9


def test_a_window_begins_with_the_commands_before_it() -> None:
    one = Robot.from_string(ARM.format('delay=".01" nsample="5"', ""))
    _, qpos, qvel = plain(one)
    _, places = replayed(one, 1, (21, ROWS - 1), InitialState(qpos[21:22], qvel[21:22]))  # a command changed at row 20
    np.testing.assert_allclose(places, qpos[21:], atol=1e-12)


def test_buffers_of_a_model_with_another_step_hold_its_delays() -> None:
    one = Robot.from_string(ARM.format('delay=".01" nsample="5"', 'delay=".004" nsample="2"'))
    for finer in (one.finer(4), apply_settings(one, {"option.timestep": 0.0005})):
        assert finer.model.opt.timestep == 0.0005 and finer.model.actuator_delay[0] == 0.01
        assert finer.model.actuator_history[0, 0] == 20 and finer.model.sensor_history[0, 0] == 8
    assert apply_settings(one, {"option.timestep": 0.004}).model.actuator_history[0, 0] == 5
