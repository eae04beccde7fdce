"""Forms of effects that go by another name: they act as written and are told as an effect of the catalogue."""

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from estexp_jax.physics.effects.base import NEVER, JointState
from estexp_jax.physics.effects.catalogue.hysteresis import Hysteresis
from estexp_jax.physics.effects.catalogue.load_bristles import LoadBristles
from estexp_jax.physics.effects.catalogue.motor_fade import MotorFade
from estexp_jax.physics.effects.catalogue.motor_heat import MotorHeat
from estexp_jax.physics.effects.catalogue.outer_backlash import OuterBacklash
from estexp_jax.physics.effects.catalogue.part_stub import PartStub
from estexp_jax.physics.effects.catalogue.rebound_limit import ReboundLimit
from estexp_jax.physics.effects.catalogue.rotor_backlash import RotorBacklash
from estexp_jax.physics.effects.catalogue.servo_damping import ServoDamping
from estexp_jax.physics.effects.catalogue.stribeck_bristles import StribeckBristles
from estexp_jax.physics.effects.catalogue.stribeck_friction import StribeckFriction
from estexp_jax.physics.effects.registry import effect, named_effects, variants
from estexp_jax.physics.effects.servos import servo_damping
from estexp_jax.physics.engines.mjx.model import mjx_model
from estexp_jax.physics.model.robot import Robot

PLAY = (0.03, 0.006, 900.0, 0.3)
"""half_gap, I, k, zeta of a play inside a servo's loop."""
IDLE = (lambda joint: joint, lambda joint: (joint, joint), lambda: (0.0, 0.0))
"""What other joints do, and what the motor is asked for."""
SERVO = """
<mujoco>
  <worldbody><body><joint name="j" axis="0 1 0"/><geom size="0.1" mass="1" pos="0.2 0 0"/></body></worldbody>
  <actuator><position name="s" joint="j" kp="20" kv="0.8" gear="2"/></actuator>
</mujoco>
"""


@pytest.mark.parametrize("variant", variants(), ids=lambda e: e.name)
def test_a_variant_is_told_under_a_name_and_with_values_of_the_catalogue(variant):
    values = {p.name: 0.3 for p in variant.parameters}
    name, told = variant.reported_as(values)
    assert name in {e.name for e in named_effects()}
    assert (
        {p.name for p in effect(name).parameters}
        <= set(told)
        <= {p.name for p in (*effect(name).parameters, *variant.parameters)}
    )
    assert effect(variant.name) is variant


def test_bristles_that_give_by_a_millimetre_are_told_as_coulomb_friction():
    assert Hysteresis().reported_as({"T": 0.2, "sigma": 130.0}) == ("coulomb_friction", {"T": 0.2})
    assert Hysteresis().reported_as({"T": 0.2, "sigma": 2.0})[0] == "hysteresis"
    levels = {"T": 0.2, "S": 0.003, "w_s": 0.3}
    for form, more in ((StribeckFriction(), {}), (StribeckBristles(), {"x": 1e-3})):
        assert form.reported_as(levels | more) == ("coulomb_friction", {"T": 0.2})
        for nearly in ({"S": 0.02}, {"T": 0.0}):
            assert form.reported_as(levels | more | nearly)[0] == "stribeck_friction"


def slid(term, p, speed, torque=0.0, dt=1e-3, seconds=0.5):
    """Force of a term at the end of a slide at constant speed, with its implicit damping taken."""
    q, one = jnp.zeros(1), jnp.ones(1)
    state, left = term.initial(p, q, q), q

    @jax.jit
    def step(q, state):
        joint = JointState(q, one * speed, one * torque, one, one * dt, one, one, lambda q, w: q, *IDLE)
        does, state = term.act(p, joint, state)
        return q + dt * speed, state, does.force - does.damping * speed

    for _ in range(round(seconds / dt)):
        q, state, left = step(q, state)
    return float(left[0])


def test_a_motor_hot_at_its_largest_torque_only_is_the_one_that_fades():
    own, less = (tuple(jnp.full(1, x) for x in p) for p in ((0.6, 2.0), (0.6, 2.0, 1.0)))
    one, states, left = jnp.ones(1), [(jnp.zeros(1),), (jnp.zeros(1),)], []
    for torque in np.random.default_rng(5).uniform(-1.0, 1.0, 200):
        now = JointState(one, one, one * torque, one, one * 0.02, one, one, lambda q, w: q, *IDLE)
        pairs = [t.act(p, now, s) for t, p, s in zip((MotorFade(), MotorHeat()), (own, less), states, strict=True)]
        states = [state for _, state in pairs]
        left.append([float(does.motor[0]) for does, _ in pairs])
    np.testing.assert_allclose(*np.array(left).T, rtol=1e-6)
    assert left[-1][0] < 0.9


def test_a_motor_that_heats_early_gets_no_weaker_than_it_can():
    p, one, state = tuple(jnp.full(1, x) for x in (0.6, 0.1, 0.2)), jnp.ones(1), (jnp.zeros(1),)
    now = JointState(one, one, one, one, one * 0.02, one, one, lambda q, w: q, *IDLE)
    does, state = MotorHeat().act(p, now, state)
    for _ in range(199):
        does, state = MotorHeat().act(p, now, state)
    assert float(does.motor[0]) == pytest.approx(0.4)


def test_bristles_slide_at_their_law():
    p = tuple(jnp.full(1, x) for x in (0.4, 0.3, 0.2, 1e-3))
    for speed in (0.05, -0.2, 1.5):
        level = 0.4 + 0.3 * np.exp(-((speed / 0.2) ** 2))
        assert slid(StribeckBristles(), p, speed) == pytest.approx(-np.sign(speed) * level, rel=1e-3)
    load = tuple(jnp.full(1, x) for x in (0.2, 1e-3))
    assert slid(LoadBristles(), load, 0.3, torque=-5.0) == pytest.approx(-1.0, rel=1e-3)


def test_bristles_give_like_a_spring_before_they_slide():
    p = tuple(jnp.full(1, x) for x in (0.4, 0.0, 0.2, 1e-2))
    assert slid(StribeckBristles(), p, 1e-3, seconds=0.5) == pytest.approx(-0.4 / 1e-2 * 5e-4, rel=0.05)


@pytest.mark.parametrize("e", [0.0, 0.5])
def test_a_rotor_rebounds_from_the_end_of_its_play_and_passes_on_its_momentum(e):
    zero, one, inertia, dt = jnp.zeros(1), jnp.ones(1), 0.002, 1e-3
    p = (one * 0.05, one * inertia, one * e)
    state, passed = (zero, one * 1.0, zero, zero), 0.0  # in the middle of its play, at 1 rad/s; the joint is held
    for _ in range(80):
        joint = JointState(zero, zero, zero, one, one * dt, one * 0.003, one, lambda q, w: zero, *IDLE)
        does, state = RotorBacklash().act(p, joint, state)
        passed += float(does.force[0]) * dt
    x, speed, *_ = (float(s[0]) for s in state)
    assert passed == pytest.approx(inertia * (1.0 + e), rel=0.01)
    assert speed == pytest.approx(-e, abs=1e-6)
    assert x == pytest.approx(0.05 - e * 0.03, abs=1.5e-3)


def hunting(dt, seconds=0.4):
    """Joint positions (rows,) 20 ms apart at steps of dt: .02 kg m2, moved by a servo that sees it beyond the play."""
    one, armature, rest = jnp.ones(1), 0.008, 0.012
    p = tuple(jnp.full(1, x) for x in PLAY)
    term, q, w = OuterBacklash(), jnp.zeros(1), jnp.zeros(1)
    state, rows = term.initial(p, q, w), []

    def servo(q, w):
        return 8.0 * (0.3 - q) - 0.1 * w

    @jax.jit
    def step(q, w, state):
        torque = servo(q, w)
        joint = JointState(q, w, torque, one, one * dt, one, one * armature, servo, *IDLE)
        does, state = term.act(p, joint, state)
        inertia = armature + rest + does.inertia
        w = (inertia * w + dt * (does.force + does.motor * torque)) / (inertia + dt * does.damping)
        return q + dt * w, w, state

    for n in range(round(seconds / dt)):
        q, w, state = step(q, w, state)
        rows += [float(q[0])] if (n + 1) % round(0.02 / dt) == 0 else []
    return np.array(rows)


def test_a_servo_with_play_inside_its_loop_moves_as_two_bodies_do():
    gap, rotor, k, zeta = PLAY
    d = 2.0 * zeta * np.sqrt(k * rotor)

    def rates(_, y):
        q, w, r, a = y
        deep = np.sign(r - q) * max(abs(r - q) - gap, 0.0)
        push = k * deep + d * (a - w)
        push = push if push * deep > 0.0 else 0.0
        return w, push / (0.02 - rotor), a, (8.0 * (0.3 - q) - 0.1 * w - push) / rotor

    two = solve_ivp(rates, (0.0, 0.4), [0.0, 0.0, gap, 0.0], t_eval=np.arange(1, 21) * 0.02, max_step=1e-4).y[0]
    assert np.ptp(two) > 0.4
    np.testing.assert_allclose(hunting(2e-4), two, atol=0.01)
    np.testing.assert_allclose(hunting(2e-3), two, atol=0.06)


def test_servo_damping_changes_the_motors_own_force():
    robot = Robot.from_string(SERVO, "servo.xml")
    assert servo_damping(robot) == pytest.approx([0.8 * 4.0])
    spec = robot.spec.copy()
    ServoDamping().write_mjcf(robot, spec, "s", {"k": 0.4})
    forces = []
    for model in (robot.model, spec.compile()):
        data = mujoco.MjData(model)
        data.qvel[0] = 3.0
        mujoco.mj_forward(model, data)
        forces.append(float(data.qfrc_actuator[0]))
    assert forces[1] - forces[0] == pytest.approx(-0.4 * 3.0)


BALL = """
<mujoco>
  <option timestep="0.001"/>
  <worldbody><body><joint name="j" type="slide" axis="0 0 1"/><geom size="0.1" mass="2"/></body></worldbody>
</mujoco>
"""


def thrown_back(**values):
    """Speed with which a ball that falls from 1 m leaves a stop, over that with which it meets it."""
    robot = Robot.from_string(BALL, "ball.xml")
    spec = robot.spec.copy()
    ReboundLimit().write_mjcf(robot, spec, "j", {"low": -1.0, "high": NEVER, "time": 0.02, "frequency": 50.0} | values)
    model = spec.compile()
    data, speeds = mujoco.MjData(model), []
    for _ in range(700):
        mujoco.mj_step(model, data)
        speeds.append(data.qvel[0])
    assert data.qpos.min() > -1.1 and min(speeds) == pytest.approx(-np.sqrt(2 * 9.81), rel=0.02)
    return max(speeds[450:]) / -min(speeds)


def test_the_less_a_stop_is_damped_the_more_it_bounces():
    back = [thrown_back(frequency=f) for f in (50.0, 125.0, 500.0)]
    assert back[0] < 0.2 < back[1] < 0.6 < back[2] < 1.0


def test_a_stop_that_bounces_is_edited_as_it_is_written():
    robot = Robot.from_string(BALL, "ball.xml")
    there = mjx_model(robot, (ReboundLimit(),))
    values = {"rebound_limit": jnp.array([[-1.0, NEVER, 0.03, 160.0]])}
    edited = there.edited(there.model, values)
    spec = robot.spec.copy()
    ReboundLimit().write_mjcf(robot, spec, "j", {"low": -1.0, "high": NEVER, "time": 0.03, "frequency": 160.0})
    written = spec.compile()
    np.testing.assert_allclose(edited.jnt_solref, written.jnt_solref)
    assert float(edited.jnt_range[0, 0]) == written.jnt_range[0, 0] == -1.0
    absent = there.edited(there.model, {"rebound_limit": jnp.array([[-NEVER, NEVER, 0.03, 160.0]])})
    np.testing.assert_allclose(absent.jnt_solref, robot.model.jnt_solref)


ARM = """
<mujoco>
  <worldbody><body name="upper"><joint name="a" axis="0 1 0"/><geom size="0.1" mass="1" pos="0.2 0 0"/>
    <body name="lower" pos="0.4 0 0"><joint name="b" axis="0 1 0"/><geom name="g" size="0.05" mass="0.5" pos="0.1 0 0"/>
    </body></body></worldbody>
  <actuator><motor name="m" joint="b"/></actuator>
</mujoco>
"""


def test_a_stub_weighs_next_to_nothing_touches_nothing_and_is_still_driven():
    robot = Robot.from_string(ARM, "arm.xml")
    spec = robot.spec.copy()
    PartStub().write_mjcf(robot, spec, "lower", {"lost": 1.0})
    written = spec.compile()
    lower = robot.index("body", "lower")
    assert written.body_mass[lower] == pytest.approx(0.005)
    assert written.body_inertia[lower] == pytest.approx(0.01 * robot.model.body_inertia[lower])
    assert written.body_mass[robot.index("body", "upper")] == pytest.approx(1.0)
    assert written.geom("g").contype[0] == 0 and written.nu == 1
    on_mjx = mjx_model(robot, (PartStub(),))
    for lost in (0.0, 1.0):
        values = jnp.zeros((len(PartStub().sites(robot)), 1)).at[PartStub().sites(robot).index("lower"), 0].set(lost)
        edited = PartStub().edit(robot, on_mjx.model, values)
        expected = written if lost else robot.model
        assert np.asarray(edited.body_mass) == pytest.approx(expected.body_mass)
        assert np.asarray(edited.body_inertia) == pytest.approx(expected.body_inertia, abs=1e-9)
