"""MuJoCo 4's springs and dampers of higher degree, and what else MJX passes over in silence, in both engines."""

from functools import cache

import mujoco
import numpy as np
import pytest

from estexp_jax.lanes.capabilities import refusal
from estexp_jax.physics.effects.changes import Change, encode, stack
from estexp_jax.physics.effects.registry import catalogue
from estexp_jax.physics.engines.choice import open_loop_simulator
from estexp_jax.physics.engines.mjx.capabilities import reduced_to_mjx
from estexp_jax.physics.engines.open_loop import OpenLoopSimulator
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.physics.window import InitialState, window_of

XML = """
<mujoco>
  <compiler angle="radian"/>
  <option timestep="0.002" integrator="Euler"/>
  <worldbody><body><joint name="a" axis="0 1 0" damping="0.02 0.03 0.01" stiffness="0.3 0.5 1.5" springref="0.2"/>
    <geom type="capsule" fromto="0 0 0 0 0 -0.3" size="0.02" mass="0.5"/>
    <body pos="0 0 -0.3"><joint name="b" axis="0 1 0" damping="0.01" stiffness="0 0 0.8"/>
      <geom type="capsule" fromto="0 0 0 0 0 -0.2" size="0.02" mass="0.2"/></body></body></worldbody>
  <actuator><motor name="m" joint="a" gear="2" damping="0.01 0.01 0.005" armature="0.002"/><motor name="n" joint="b"/>
  </actuator>
  <sensor><jointpos joint="a"/></sensor>
</mujoco>
"""
ROWS, STEP = 250, 0.002
EFFECTS = catalogue(["joint_stiffness"])
START = InitialState(np.array([0.9, -1.0]), np.array([4.0, -6.0]))
COMMANDS = np.stack([np.sin(0.05 * np.arange(ROWS)), 0.3 * np.cos(0.03 * np.arange(ROWS))], axis=1)


@cache
def robot(integrator: str) -> Robot:
    return Robot.from_string(XML.replace("Euler", integrator))


@cache
def simulator(integrator: str, engine: str) -> OpenLoopSimulator:
    return open_loop_simulator(robot(integrator), EFFECTS, [robot(integrator)], width=1, engine=engine)


def in_c(model: mujoco.MjModel) -> np.ndarray:
    data, path = mujoco.MjData(model), []
    data.qpos[:], data.qvel[:] = START.qpos, START.qvel
    for command in COMMANDS:
        path.append(data.qpos.copy())
        data.ctrl[:] = command
        mujoco.mj_step(model, data)
    return np.array(path)


def replayed(integrator: str, engine: str, *changes: Change) -> np.ndarray:
    here, nothing = robot(integrator), np.full((ROWS, 2), np.nan)
    log = Recording("log", STEP * np.arange(ROWS), COMMANDS, np.ones((ROWS, 2)), nothing[:, :1], nothing, nothing)
    stretch = window_of([log], 0, (0, ROWS - 1), STEP, START)
    values = stack([encode(here, EFFECTS, changes)])
    return simulator(integrator, engine).replay(values, [stretch], np.zeros(1, int)).qpos[0]


@pytest.mark.parametrize(
    ("integrator", "engine", "off"),
    [
        ("Euler", "lanes", 1e-5),
        ("Euler", "mjx", 1e-5),
        ("RK4", "lanes", 1e-5),
        pytest.param("RK4", "mjx", 2e-3, marks=pytest.mark.slow),
    ],
)
def test_springs_and_dampers_of_higher_degree_act_as_in_c(integrator: str, engine: str, off: float) -> None:
    """MJX takes their tangents through the stages of a step by Runge and Kutta's method."""
    path = replayed(integrator, engine)
    np.testing.assert_allclose(path, in_c(robot(integrator).model), atol=off)


@pytest.mark.parametrize("engine", ["lanes", "mjx"])
def test_a_spring_that_is_added_has_a_rest_of_its_own(engine: str) -> None:
    spec, change = robot("Euler").spec.copy(), Change("joint_stiffness", "a", {"k": 2.0, "q0": -0.5})
    EFFECTS[0].write_mjcf(robot("Euler"), spec, "a", change.values)
    np.testing.assert_allclose(replayed("Euler", engine, change), in_c(spec.compile()), atol=1e-5)


def test_what_mjx_would_pass_over_is_told() -> None:
    models = {
        "delays of actuators": XML.replace('gear="2"', 'gear="2" delay="0.01" nsample="5"'),
        "moving surfaces": XML.replace('mass="0.5"', 'mass="0.5" surfacevel="1 0 0"'),
        "springs that yield": XML.replace('name="b"', 'name="b" springyield="0.1"'),
    }
    for words, xml in models.items():
        [left_out] = reduced_to_mjx(Robot.from_string(xml)).left_out
        assert left_out.startswith(words)
    assert reduced_to_mjx(robot("Euler")).left_out == ()


def test_lanes_leave_curved_dampers_of_floating_bodies_to_mjx() -> None:
    xml = """<mujoco><worldbody><body pos="0 0 1"><joint name="base" type="free" damping="0 1"/><geom size="0.1"/>
      <body><joint name="arm"/><geom size="0.1" pos="0.2 0 0"/></body></body></worldbody></mujoco>"""
    reason = refusal(mujoco.MjModel.from_xml_string(xml))
    assert reason == "a damping polynomial of free joint 'base' is not supported"
