"""A robot on MJX: terms at work, arming, motors off, and what MJX cannot do."""

from collections.abc import Callable
from itertools import product

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
import pytest
from mujoco import mjx

from estexp_jax.errors import InputError
from estexp_jax.physics.effects.changes import encode, parse_change, stack
from estexp_jax.physics.effects.registry import catalogue
from estexp_jax.physics.engines.mjx.model import mjx_model, with_motors_switched
from estexp_jax.physics.model.robot import Robot
from tests.physics.conftest import COMPARED, Lab, marks
from tests.physics.reference import converged, visit
from tests.physics.robots import robot


def _renewed(subject: Robot, joint: str, mu: float) -> Callable[[mujoco.MjModel, mujoco.MjData], None]:
    """Friction of mu times this step's motor torque, put into the C engine's model before each step."""
    dof = int(subject.model.jnt_dofadr[subject.index("joint", joint)])

    def term(model: mujoco.MjModel, data: mujoco.MjData) -> None:
        probe = mujoco.MjData(model)
        probe.qpos[:], probe.qvel[:], probe.ctrl[:] = data.qpos, data.qvel, data.ctrl
        mujoco.mj_forward(model, probe)
        model.dof_frictionloss[dof] = subject.model.dof_frictionloss[dof] + mu * abs(probe.qfrc_actuator[dof])

    return term


def _braked(subject: Robot, joint: str, k: float) -> Callable[[mujoco.MjModel, mujoco.MjData], None]:
    dof = int(subject.model.jnt_dofadr[subject.index("joint", joint)])

    def term(model: mujoco.MjModel, data: mujoco.MjData) -> None:
        model.dof_damping[dof] = subject.model.dof_damping[dof] + k

    return term


TERMS = {
    ("pendulum", "load_dependent_friction@shoulder mu=0.4"): _renewed(robot("pendulum"), "shoulder", 0.4),
    ("cartpole", "load_dependent_friction@rail mu=0.6"): _renewed(robot("cartpole"), "rail", 0.6),
    ("quadruped", "load_dependent_friction@knee_f mu=0.9"): _renewed(robot("quadruped"), "knee_f", 0.9),
    ("pendulum", "back_emf@servo k=0.3"): _braked(robot("pendulum"), "shoulder", 0.3),
    ("quadruped", "back_emf@hip_l k=1.0"): _braked(robot("quadruped"), "hip_l", 1.0),
}


@pytest.mark.parametrize(
    ("engine", "name", "text"),
    [
        pytest.param(engine, name, text, marks=marks(engine, name))
        for engine, (name, text) in product(("lanes", "mjx"), TERMS)
    ],
)
def test_a_term_agrees_with_the_c_engine_given_each_steps_parameters(
    lab: Callable[[str, str], Lab], engine: str, name: str, text: str
) -> None:
    subject = robot(name)
    states = visit(subject, converged(subject.spec.copy().compile()), seed=5, n=8, term=TERMS[name, text])
    values = [encode(subject, COMPARED, changes) for changes in ([parse_change(text, subject)], [])]
    ours, nominal = (lab(engine, name).run(stack([v] * 8), states) for v in values)
    assert np.abs(ours["next_qvel"] - states.next_qvel).max() < 1e-4 * max(1.0, np.abs(states.next_qvel).max())
    assert np.abs(ours["final_qpos"] - states.final_qpos).max() < 1e-3
    assert np.abs(nominal["final_qpos"] - states.final_qpos).max() > 2e-3


def test_friction_is_armed_only_where_an_effect_needs_it() -> None:
    plain = mjx_model(robot("quadruped"), catalogue(["body_mass", "back_emf"]))
    assert not np.asarray(plain.model.dof_frictionloss).any()
    for name in ("coulomb_friction", "load_dependent_friction"):
        armed = np.asarray(mjx_model(robot("cartpole"), catalogue([name])).model.dof_frictionloss)
        assert armed.min() > 0.0 and armed[0] == pytest.approx(0.3)
    assert not robot("quadruped").model.dof_frictionloss.any(), "the nominal model is not touched"


FREE = """
<mujoco>
  <worldbody>
    <body><joint name="j" axis="0 1 0"/><geom size="0.1" mass="1" pos="0.3 0 0"/><site name="s" pos="0.3 0 0"/></body>
  </worldbody>
  <sensor><accelerometer site="s"/></sensor>
</mujoco>
"""


@pytest.mark.parametrize("xml", [FREE, FREE.replace("<geom ", '<geom contype="0" conaffinity="0" ')])
def test_accelerations_are_read_also_where_nothing_constrains(xml: str) -> None:
    """MJX's forward pass ends before the sensors of accelerations where a model has no constraint rows."""
    subject = Robot.from_string(xml)
    on = mjx_model(subject, ())
    data = mujoco.MjData(subject.model)
    data.qvel[:] = 2.0
    mujoco.mj_forward(subject.model, data)
    ours = jax.jit(mjx.forward)(on.model, on.data.replace(qvel=jnp.full(1, 2.0)))
    np.testing.assert_allclose(ours.sensordata, data.sensordata, rtol=1e-4, atol=1e-4)
    assert np.abs(data.sensordata).max() > 1.0


def test_motors_that_are_off_give_nothing() -> None:
    on = mjx_model(robot("pendulum"), ())
    off = with_motors_switched(on.model, np.zeros(1))
    assert not np.asarray(off.actuator_gainprm).any() and not np.asarray(off.actuator_biasprm).any()
    same = with_motors_switched(on.model, np.ones(1))
    np.testing.assert_array_equal(same.actuator_gainprm, on.model.actuator_gainprm)


def test_what_mjx_cannot_simulate_is_refused_by_name() -> None:
    xml = FREE.replace("<worldbody>", '<option><flag override="enable"/></option><worldbody>')
    with pytest.raises(InputError, match="forced.xml: MJX cannot simulate this model: mjENBL_OVERRIDE"):
        mjx_model(Robot.from_string(xml, "forced.xml"), ())
