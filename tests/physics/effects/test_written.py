"""What effects write into MJCF does in MuJoCo alone what they do in our simulator, at the user's own step."""

import mujoco
import numpy as np
import pytest

from estexp_jax.physics.effects.base import Edit
from estexp_jax.physics.effects.changes import parse_change
from estexp_jax.physics.effects.registry import named_effects
from estexp_jax.physics.effects.written import mjcf_refusal, written
from tests.physics.exported import exported, robot_of

EXACT = (
    ("servos", "command_delay@lift delay=0.03", "implicitfast"),
    ("servos", "command_delay@* delay=0.0251", "Euler"),
    ("motors", "command_delay@push delay=0.0105", "implicitfast"),
    ("servos", "sensor_delay@bent delay=0.02", "RK4"),
    ("motors", "sensor_delay@lean delay=0.0137", "Euler"),
    ("servos", "cogging@elbow A=0.3 n=7 phase=0.5", "implicitfast"),
    ("motors", "cogging@swing A=0.2 n=12.5 phase=-0.5", "Euler"),
    ("servos", "torque_offset@elbow T=0.4", "RK4"),
    ("motors", "torque_offset@rail T=-0.7", "Euler"),
    ("servos", "back_emf@bend k=0.3", "implicitfast"),
    ("motors", "back_emf@push k=2", "RK4"),
    ("motors", "crosstalk@swing from=1 g=0.3", "implicitfast"),
    ("motors", "crosstalk@rail from=2 g=-0.5", "Euler"),
    ("servos", "external_force@lower x=1 y=0.5 z=-2 k=0", "implicitfast"),
    ("servos", "external_force@lower x=1 y=0.5 z=2 k=5", "Euler"),
    ("servos", "gravity_compensation@* share=0.6", "implicitfast"),
    ("motors", "gravity_compensation@swing share=-0.5", "Euler"),
    ("motors", "tied_outputs@turn with=1", "implicitfast"),
    ("servos", "gravity_tilt angle=0.2 axis=1.57", "Euler"),
    ("servos", "cogging@elbow A=0.3 n=7 phase=0.5 + torque_offset@elbow T=0.3 + command_delay@* delay=0.02", "Euler"),
)
"""Robot, effects and integrator where the two are the same but for single precision."""
CLOSE = (
    ("servos", "command_delay@lift delay=0.03", "RK4", 1e-05),
    ("servos", "actuator_lag@lift tau=0.03", "implicitfast", 0.01),
    ("servos", "actuator_lag@* tau=0.003", "Euler", 0.05),
    ("motors", "actuator_lag@push tau=0.05", "RK4", 0.001),
    ("motors", "quadratic_drag@rail c=3", "implicitfast", 0.003),
    ("servos", "hysteresis@elbow T=0.4 sigma=20", "implicitfast", 0.03),
    ("servos", "hysteresis@elbow T=0.4 sigma=200", "Euler", 0.02),
    ("servos", "stribeck_bristles@elbow T=0.3 S=0.3 w_s=0.2 x=0.005", "implicitfast", 0.1),
    ("servos", "stribeck_friction@elbow T=0.3 S=0.3 w_s=0.2", "Euler", 0.12),
    ("motors", "stribeck_friction@swing T=0.2 S=0.1 w_s=0.5", "implicitfast", 0.02),
    ("servos", "asymmetric_friction@elbow T=0.3 a=0.3", "implicitfast", 0.03),
    ("servos", "smooth_friction@elbow T=0.3 a=0 w_0=0.05", "implicitfast", 0.12),
    ("servos", "joint_compliance@elbow k=50 d=0.1 I=0.004", "implicitfast", 0.06),
    ("motors", "outer_compliance@swing k=20 d=0.05 I=0.003", "Euler", 0.03),
    ("servos", "backlash@elbow half_gap=0.05", "implicitfast", 0.1),
    ("servos", "rotor_backlash@elbow half_gap=0.05 I=0.003 e=0.3", "Euler", 0.08),
    ("motors", "outer_backlash@swing half_gap=0.1 I=0.003 k=30 zeta=0.3", "implicitfast", 0.4),
    ("servos", "mount_compliance@base k=300 d=2", "Euler", 0.35),
)
"""The same where the two are integrated otherwise: how far they may be apart at a quarter of the step, as a share."""
REFUSED = (
    ("servos", "command_delay@lift delay=0.001", "shorter than a step"),
    ("servos", "crosstalk@elbow from=1 g=0.3", "servo"),
    ("servos", "outer_compliance@elbow k=50 d=0.1 I=0.004", "servo"),
    ("servos", "gravity_compensation@elbow share=0.5", "alike"),
    ("servos", "tied_outputs@bend with=1", "servo"),
    ("motors", "backlash@rail half_gap=0.01", "armature"),
    ("motors", "dead_band@push half_width=0.2", "no element"),
)


@pytest.mark.parametrize(("name", "text", "integrator"), EXACT)
def test_it_is_exact(name: str, text: str, integrator: str) -> None:
    assert exported(name, text, integrator).share < 1e-5


@pytest.mark.parametrize(("name", "text", "integrator", "bound"), CLOSE)
def test_it_is_close(name: str, text: str, integrator: str, bound: float) -> None:
    assert exported(name, text, integrator, finer=4).share < bound


def test_every_effect_that_adds_something_to_mjcf_is_compared() -> None:
    texts = [text for _, text, *_ in (*EXACT, *CLOSE)]
    compared = {part.partition("@")[0].partition(" ")[0] for text in texts for part in text.split(" + ")}
    wanted = {e.name for e in named_effects() if e.in_mjcf and (e.extends_mjcf or not isinstance(e, Edit))}
    assert wanted <= compared


@pytest.mark.parametrize(("name", "text", "why"), REFUSED)
def test_what_mujoco_cannot_hold_is_left_out_and_told(name: str, text: str, why: str) -> None:
    robot = robot_of(name)
    change = parse_change(text, robot)
    assert why in mjcf_refusal(robot, change)
    np.testing.assert_equal(_numbers(written(robot, [change])), _numbers(robot.spec.copy()))


def _numbers(spec: mujoco.MjSpec) -> dict[str, np.ndarray]:
    model = spec.compile()
    names = ("actuator_gainprm", "actuator_dynprm", "dof_armature", "body_gravcomp", "qpos0", "actuator_delay")
    return {name: np.array(getattr(model, name)) for name in names} | {"tendons": np.array(model.ntendon)}


def test_addresses_stay_where_rotors_are_added_and_keyframes_hold_them() -> None:
    robot = robot_of("servos")
    texts = ("joint_compliance@elbow k=50 d=0.1 I=0.004", "actuator_lag@lift tau=0.03", "cogging@elbow A=0.3 n=7")
    model = written(robot, [parse_change(text, robot) for text in texts]).compile()
    assert model.nu == robot.model.nu and model.nq == robot.model.nq + 1
    for kind in ("joint", "actuator", "body", "sensor"):
        names = robot.names(kind)
        count = {"joint": "njnt", "actuator": "nactuator", "body": "nbody", "sensor": "nsensor"}[kind]
        assert tuple(getattr(model, kind)(i).name for i in range(getattr(model, count)))[: len(names)] == names
    np.testing.assert_array_equal(model.key_qpos[0], [0.2, 0.4, 0.4])
    np.testing.assert_array_equal(model.key_ctrl[0], [0.2, 0.4])


def test_delays_that_a_model_has_add_up() -> None:
    robot = robot_of("servos")
    later = robot.spec.copy()
    later.actuators[0].delay, later.actuators[0].nsample = 2.5 * 0.002, 3
    again = type(robot).from_spec(later)
    model = written(again, [parse_change("command_delay@lift delay=0.004", again)]).compile()
    assert model.actuator_delay[0] == pytest.approx(4.5 * 0.002)
