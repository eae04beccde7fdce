"""Closed loops on C: robots that lanes refuse, hidden variables that last, the motion of plain MuJoCo."""

import mujoco
import numpy as np
import pytest

from estexp_jax.physics.effects.changes import encode, neutral, parse_change, stack
from estexp_jax.physics.effects.registry import catalogue
from estexp_jax.physics.engines.c.closed_loop import CClosedLoop
from estexp_jax.physics.engines.choice import closed_loop_simulator
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.control.network import RecurrentPolicy

BIPED = """<mujoco><option timestep="0.004" integrator="implicitfast"/><default><joint damping="0.3" armature="0.005"/>
<position kp="20" forcerange="-8 8"/></default><worldbody><geom type="plane" size="10 10 .1"/>
<body name="trunk" pos="0 0 0.36"><freejoint/><geom type="box" size="0.08 0.12 0.05" density="600"/>
<body name="leg_l" pos="0 0.09 -0.05"><joint name="hip_l" type="ball" stiffness="9"/><geom type="capsule" size="0.025"
fromto="0 0 0 0 0 -0.15" density="600"/><body name="shin_l" pos="0 0 -0.15"><joint name="knee_l" axis="0 1 0"/>
<geom type="capsule" size="0.022" fromto="0 0 0 0.02 0 -0.14" density="600"/></body></body>
<body name="leg_r" pos="0 -0.09 -0.05"><joint name="hip_r" axis="0 1 0"/><geom type="capsule" size="0.025"
fromto="0 0 0 0 0 -0.15" density="600"/><body name="shin_r" pos="0 0 -0.15"><joint name="knee_r" axis="0 1 0"/>
<geom type="capsule" size="0.022" fromto="0 0 0 0.02 0 -0.14" density="600"/></body></body></body></worldbody>
<tendon><fixed name="both"><joint joint="knee_l" coef="1"/><joint joint="knee_r" coef="1"/></fixed></tendon><actuator>
<position name="m_knee_l" joint="knee_l"/><position name="m_hip_r" joint="hip_r"/>
<position name="m_knee_r" joint="knee_r"/></actuator><sensor><jointpos name="s_l" joint="knee_l"/>
<jointpos name="s_r" joint="knee_r"/></sensor></mujoco>"""
ROWS, SUBSTEPS = 40, 3


@pytest.fixture(scope="module")
def biped() -> CClosedLoop:
    robot, effects = Robot.from_string(BIPED, "biped.xml"), catalogue(["motor_weakness", "hysteresis", "body_mass"])
    made = closed_loop_simulator(robot, effects, policy=RecurrentPolicy(), rows=ROWS, control_step=0.012, population=40)
    assert isinstance(made, CClosedLoop)
    return made


def test_a_robot_that_lanes_refuse_is_driven_by_c_and_nothing_of_it_is_left_out(biped: CClosedLoop) -> None:
    assert biped.choice.engine == "c"
    assert "not supported by the lanes engine" in biped.choice.reason
    assert biped.left_out == ()


def test_it_moves_as_plain_mujoco_moves_it(biped: CClosedLoop) -> None:
    rng = np.random.default_rng(2)
    outputs = rng.uniform(-0.6, 0.6, (3, 3))
    values = stack([neutral(biped.robot, biped.catalogue)] * 3)
    found = biped.rollout(values, biped.policy.constant(outputs, 2), biped.home(values), ROWS)
    model = biped.robot.model
    for k in range(3):
        data = mujoco.MjData(model)
        data.qpos[:] = biped.robot.home()
        data.ctrl[:] = found.commands[k, 0]
        for row in range(ROWS):
            np.testing.assert_allclose(found.readings[k, row], data.qpos[[-3, -1]][[0, 1]], atol=1e-5)
            np.testing.assert_allclose(found.position[k, row], data.qpos[:3], atol=1e-5)
            mujoco.mj_step(model, data, SUBSTEPS)
        np.testing.assert_allclose(found.final.qpos[k], data.qpos, atol=1e-5)
    assert not found.failed.any()


def test_hidden_variables_last_from_one_rollout_to_the_next(biped: CClosedLoop) -> None:
    changes = [
        [parse_change("hysteresis@knee_l T=0.5 sigma=20", biped.robot)],
        [],
        [parse_change("body_mass@shin_r dm=0.2", biped.robot)],
    ] * 12  # so many that they fall into two chunks, of which not each has all effects
    values = stack([encode(biped.robot, biped.catalogue, c) for c in changes])
    weights = np.random.default_rng(3).uniform(-1.0, 1.0, (len(changes), biped.n_weights)).astype(np.float32)
    weights[:] = biped.policy.constant(np.full((1, 3), 0.3), 2)
    start = biped.settle(values, 10)
    whole = biped.rollout(values, weights, start, 20)
    first = biped.rollout(values, weights, start, 10)
    second = biped.rollout(values, weights, first.final, 10)
    np.testing.assert_array_equal(second.readings, whole.readings[:, 10:])
    assert np.abs(whole.final.hidden["hysteresis"][0]).max() > 0.0
    assert np.abs(whole.final.hidden["hysteresis"][1]).max() == 0.0
    assert np.abs(whole.readings[0] - whole.readings[1]).max() > 1e-3
    assert np.abs(whole.readings[2] - whole.readings[1]).max() > 1e-5


def test_it_is_the_same_robot_at_a_finer_step(biped: CClosedLoop) -> None:
    finer = biped.finer(2)
    assert finer.robot.model.opt.timestep == pytest.approx(biped.robot.model.opt.timestep / 2)
    assert finer.substeps == 2 * biped.substeps
