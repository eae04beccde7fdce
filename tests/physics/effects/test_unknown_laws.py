"""Terms of unknown laws: nothing at amplitude zero, the force that their equation says, in both engines alike."""

from contextlib import nullcontext

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from estexp_jax.physics.effects.base import JointForce, JointState, Term, neutral_values
from estexp_jax.physics.effects.changes import Change, encode, stack
from estexp_jax.physics.effects.laws.base import Course, JointLaw, Reach
from estexp_jax.physics.effects.laws.library import law_terms
from estexp_jax.physics.effects.registry import catalogue, effect, named, nameless, variants
from estexp_jax.physics.engines.choice import open_loop_simulator
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.physics.window import InitialState, window_of
from tests.discovery.planted import nominal
from tests.physics.robots import ROBOTS, robot

every_law = pytest.mark.parametrize("law", law_terms(), ids=lambda law: law.name)
Q, W, M = np.linspace(-1.2, 1.4, 27), np.linspace(-3.0, 3.1, 27), np.linspace(2.0, -2.5, 27)
FASTER = np.cos(2.0 * Q)
"""Acceleration."""
Q2, W2, M2 = np.cos(Q), np.sin(3.0 * W), np.cos(2.0 * W)
ASKED = M + 0.2 * W
"""A servo's demand, of which damping takes some away."""
REACH = Reach(-1.2, 1.4, 3.0, 8.0, 2.0, (1,))


def moment() -> JointState:
    q, w, m = (jnp.asarray(x, jnp.float32) for x in (Q, W, M))
    one = jnp.ones_like(q)

    def motion_of(number):
        there = number > 1.5
        return jnp.where(there, jnp.asarray(Q2), 0.0), jnp.where(there, jnp.asarray(W2), 0.0)

    def torque_of(number):
        return jnp.where(number > 1.5, jnp.asarray(M2), 0.0)

    asked = (jnp.asarray(ASKED - 3.0 * Q, jnp.float32), jnp.asarray(ASKED, jnp.float32))
    return JointState(q, w, m, one, 0.002, one, one, lambda q, w: m, torque_of, motion_of, lambda: asked)


def force(name: str, *p: float, state: tuple = ()) -> np.ndarray:
    """On the joint, with what is implicit taken at the present speed."""
    law = effect(name)
    assert isinstance(law, JointLaw)
    does, _ = law.act(tuple(jnp.full(len(Q), x) for x in p), moment(), tuple(jnp.full(len(Q), x) for x in state))
    total = does.force - does.damping * W - does.friction * np.sign(W) - does.inertia * FASTER
    total = total + (does.motor - 1.0) * M + does.command
    return np.asarray(total, float) + np.zeros(len(Q))


X = (Q - 0.3) / 0.2
EXPECTED = {
    "law_square": ((1.5, 0.3), 1.5 * (Q - 0.3) ** 2),
    "law_cube": ((1.5, 0.3), -1.5 * (Q - 0.3) ** 3),
    "law_bump": ((0.4, 0.3, 0.2), 0.4 * np.exp(-(X**2))),
    "law_detent": ((0.4, 0.3, 0.2), -0.4 * X * np.exp(-(X**2))),
    "law_upper_spring": ((2.0, 0.3), -2.0 * np.maximum(Q - 0.3, 0.0)),
    "law_lower_spring": ((2.0, 0.3), -2.0 * np.minimum(Q - 0.3, 0.0)),
    "law_one_way_damping": ((0.2,), -0.2 * np.abs(W)),
    "law_cubic_drag": ((0.2,), -0.2 * W**3),
    "law_smooth_friction": ((0.5, 0.4), -0.5 * np.tanh(W / 0.4)),
    "law_hump": ((0.5, 0.8), -(W / 0.8) / (1.0 + (W / 0.8) ** 2)),
    "law_place_damping": ((0.5, 0.3), -0.5 * (Q - 0.3) ** 2 * W),
    "law_two_way_friction": ((0.5, 0.6), -0.5 * (1.0 + 0.6 * np.sign(W)) * np.sign(W)),
    "law_friction_wave": ((0.5, 0.6, 4.0, 0.2), -0.5 * (1.0 + 0.6 * np.sin(4.0 * Q + 0.2)) * np.sign(W)),
    "law_tight_spot": ((0.5, 0.3, 0.2), -0.5 * np.exp(-(X**2)) * np.sign(W)),
    "law_tow": ((0.3, 2.0), 0.3 * W2),
    "law_fling": ((0.3, 2.0), 0.3 * np.abs(W2) * W2),
    "law_square_fling": ((0.3, 2.0), 0.3 * W2**2),
    "law_stir": ((0.3, 2.0), -0.3 * np.abs(W2) * W),
    "law_whirl": ((0.3, 2.0), 0.3 * W2 * W),
    "law_tie": ((0.3, 2.0, 0.1), -0.3 * (Q2 - 0.1)),
    "law_soft_motor": ((0.4,), (1.0 / np.sqrt(1.0 + 0.4 * M**2) - 1.0) * M),
    "law_slow_motor": ((0.2,), -0.2 * np.abs(W) * M),
    "law_damping": ((0.2,), -0.2 * W),
    "law_drag": ((0.2,), -0.2 * np.abs(W) * W),
    "law_dry_friction": ((0.2,), -0.2 * np.sign(W)),
    "law_inertia": ((0.2,), -0.2 * FASTER),
    "law_push": ((0.2,), 0.2 + 0.0 * W),
    "law_spring": ((0.7, 0.3), -0.7 * (Q - 0.3)),
    "law_falling_friction": ((0.5, 0.8), -0.5 * np.sign(W) / (1.0 + (W / 0.8) ** 2)),
    "law_load_friction": ((0.3,), -0.3 * np.abs(M) * np.sign(W)),
    "law_motor_brake": ((0.2,), -0.2 * W),
    "law_weak_motor": ((0.3,), -0.3 * M),
    "law_clipped_motor": ((0.6, 1.1), -0.6 * np.sign(M) * np.maximum(np.abs(M) - 1.1, 0.0)),
    "law_deaf_motor": ((0.6, 1.1), -0.6 * np.clip(ASKED, -1.1, 1.1)),
    "law_driven": ((0.3, 2.0), 0.3 * M2),
    "law_wave": ((0.2, 7.0, 0.4), 0.2 * np.sin(7.0 * Q + 0.4)),
}


REMEMBERING = {
    "law_rhythm": (0.4, 1.5, 0.3),
    "law_creep": (5.0, 0.5),
    "law_thinning": (0.4, 2.0, 0.5),
    "law_warm_motor": (0.6, 0.3, 0.5),
    "law_late_command": (0.7, 0.05),
    "law_bristles": (0.4, 0.02),
}
"""Laws with hidden variables, and values of theirs."""


def test_the_library_is_one_of_its_own() -> None:
    names = [e.name for e in (*named(), *variants(), *law_terms(), *nameless())]
    assert len(set(names)) == len(names)
    assert {law.name for law in law_terms()} == {*EXPECTED, *REMEMBERING}
    assert {law.stands_for for law in law_terms()} - {""} <= {e.name for e in named()}


@pytest.mark.parametrize("name", EXPECTED)
def test_the_force_is_what_the_equation_says(name: str) -> None:
    p, expected = EXPECTED[name]
    np.testing.assert_allclose(force(name, *p), expected, rtol=1e-4, atol=1e-5)


def test_a_rhythm_goes_by_the_time_since_the_beginning() -> None:
    assert force("law_rhythm", 0.4, 1.5, 0.3, state=(2.2,)) == pytest.approx(
        0.4 * np.sin(3.0 * np.pi * 2.2 + 0.3), rel=1e-4
    )
    law, p = effect("law_rhythm"), tuple(jnp.full(len(Q), x) for x in (0.4, 1.5, 0.3))
    assert isinstance(law, JointLaw)
    _, (after,) = law.act(p, moment(), (jnp.full(len(Q), 2.2),))
    assert np.asarray(after) == pytest.approx(2.202)


def test_a_motor_whose_supply_sags_gives_less_the_more_is_asked():
    sag, p = effect("law_sag"), (jnp.full(len(Q), 0.55),)
    assert isinstance(sag, Term) and sag.kind == "actuator"
    does, _ = sag.act(p, moment(), ())
    share = np.maximum(1.0 - 0.55 * np.abs(M), 0.0)
    assert share.min() == 0.0, "at the largest torques nothing is left"
    np.testing.assert_allclose(does.motor, share, atol=1e-6)
    for site in sag.sites(robot("quadruped")):
        assert "0.55 |m|" in sag.numbered({"a": 0.55}) and site in sag.sentence(site, {"a": 0.55})


def test_what_creeps_pushes_back_like_a_spring_and_then_lets_go() -> None:
    law = effect("law_creep")
    assert isinstance(law, JointLaw)
    p, one = (jnp.full(1, 5.0), jnp.full(1, 0.5)), jnp.ones(1)
    state, forces = law.initial(p, one, one), []
    for step in range(1500):
        w = one * (2.0 if step < 50 else 0.0)  # 0.1 rad in 50 ms, then held
        does, state = law.act(p, moment()._replace(w=w, dt=1e-3 * one), state)
        forces.append(float(does.force[0]))
    assert forces[49] == pytest.approx(-0.5, rel=0.06)
    assert forces[549] == pytest.approx(forces[49] * np.exp(-1.0), rel=1e-2)


def test_what_thins_resists_less_the_longer_it_moves() -> None:
    assert force("law_thinning", 0.4, 2.0, 1.0, state=(0.0,)) == pytest.approx(-0.4 * W, rel=1e-4, abs=1e-6)
    assert force("law_thinning", 0.4, 2.0, 1.0, state=(1.5,)) == pytest.approx(-0.1 * W, rel=1e-4, abs=1e-6)


def test_a_warm_motor_gives_less() -> None:
    assert force("law_warm_motor", 0.6, 0.3, 0.5, state=(0.0,)) == pytest.approx(0.0 * M, abs=1e-6)
    assert force("law_warm_motor", 0.6, 0.3, 0.5, state=(0.3,)) == pytest.approx(-0.6 * M, rel=1e-4, abs=1e-6)
    assert force("law_warm_motor", 0.6, 0.3, 0.5, state=(0.1,)) == pytest.approx(-0.2 * M, rel=1e-4, abs=1e-6)
    assert force("law_warm_motor", 0.6, 0.3, 0.5, state=(300.0,)) == pytest.approx(-0.6 * M, rel=1e-4, abs=1e-6)


def test_of_a_late_command_a_share_is_missing_wherever_the_joint_is() -> None:
    late = -0.7 * (ASKED - 3.0 * Q - 1.2) * (1.0 + np.exp(-0.002 / 0.05)) / 2.0  # the mean over the step
    assert force("law_late_command", 0.7, 0.05, state=(1.2, 1.0)) == pytest.approx(late, rel=1e-4, abs=1e-5)
    assert force("law_late_command", 0.7, 0.05, state=(0.0, 0.0)) == pytest.approx(0.0 * Q, abs=1e-5), (
        "at the beginning"
    )


SERVO = """
<mujoco>
  <option timestep="0.005" integrator="implicitfast"/>
  <worldbody><body><joint name="j" axis="0 1 0" damping="0.02" armature="0.01"/>
    <geom type="capsule" size="0.02" fromto="0 0 0 0.3 0 0" mass="0.3"/></body></worldbody>
  <actuator><position name="s" joint="j" gear="0.8" kp="8" kv="0.3" forcerange="-4 4" ctrlrange="-1.4 1.4"/></actuator>
</mujoco>
"""
NM = 0.8 * 8.0
"""Torque for each unit of its command, N m."""


@pytest.mark.parametrize(
    ("law", "same"),
    [
        ({"law_deaf_motor": {"a": 1.0, "m_0": NM * 0.15}}, {"dead_band": {"half_width": 0.15}}),
        ({"law_late_command": {"a": 1.0, "T": 0.12}}, {"actuator_lag": {"tau": 0.12}}),
    ],
    ids=["dead_band", "actuator_lag"],
)
def test_laws_of_a_servos_command_do_what_its_named_effects_do(law: dict, same: dict) -> None:
    subject, rows = Robot.from_string(SERVO, "servo.xml"), 81
    time, nothing = 0.01 * np.arange(rows), np.full((rows, 1), np.nan)
    recording = Recording("r", time, 0.9 * np.cos(5.0 * time)[:, None], np.ones((rows, 1)), nothing, nothing, nothing)
    stretch = window_of([recording], 0, (0, rows - 1), 0.005, InitialState(np.zeros(1), np.zeros(1)))
    without = {next(iter(same)): {}}
    ways = []
    for acts, site in ((law, "j"), (same, "s"), (without, "s")):
        [(name, parameters)] = acts.items()
        effects, changes = catalogue([name]), [Change(name, site, parameters)] if parameters else []
        values = stack([encode(subject, effects, changes)])
        for engine in ("lanes", "mjx"):
            replay = open_loop_simulator(subject, effects, [subject], engine=engine, width=1).replay
            ways.append(replay(values, [stretch], np.zeros(1, int)).qpos[0, :, 0])
    for way in ways[1:4]:
        np.testing.assert_allclose(way, ways[0], atol=3e-3)
    assert np.abs(ways[4] - ways[0]).max() > 0.05


def test_bristles_hold_like_a_spring_until_they_slip() -> None:
    law = effect("law_bristles")
    assert isinstance(law, JointLaw)
    way = np.array([0.0, 1e-4, 0.2, 0.4, 0.4 - 1e-4])
    course = Course(np.arange(5.0), way, *np.zeros((3, 5)))
    built, _ = law.remembered((0.5, 0.01), course)
    assert built[1] == pytest.approx(0.5 * 1e-4 / 0.01, rel=0.01)
    assert built[2:4] == pytest.approx([0.5, 0.5]) and built[3] - built[4] == pytest.approx(0.01, rel=0.02)


@pytest.mark.parametrize("name", REMEMBERING)
def test_what_is_remembered_is_what_the_steps_lead_to(name: str) -> None:
    law = effect(name)
    assert isinstance(law, JointLaw)
    values, steps = REMEMBERING[name], np.arange(40)
    way, asked = 0.05 * (1.0 - np.cos(steps / 5.0)), np.sin(steps / 3.0)
    course = Course(0.01 * steps, way, np.sin(steps / 5.0), np.cos(steps / 7.0), asked)
    [told, *_] = law.remembered(values, course)
    one, p = jnp.ones(1), tuple(jnp.full(1, x) for x in values)
    state, stepped = law.initial(p, course.q[0] * one, one), []
    for q, w, m, c in zip(*course[1:], strict=True):
        at = moment()._replace(
            q=q * one, w=w * one, torque=m * one, dt=0.01 * one, asked=lambda c=c: (c * one, c * one)
        )
        stepped.append(float(state[0][0]))
        _, state = law.act(p, at, state)
    lag = 1 if name == "law_bristles" else 0  # at each step they follow the way of the one before
    np.testing.assert_allclose(told[: len(told) - lag], stepped[lag:], atol=1e-5)


@every_law
def test_without_amplitude_nothing_changes(law: JointLaw) -> None:
    values = jnp.asarray(neutral_values(law, len(Q)), jnp.float32)
    assert law.parameters[0].neutral == 0.0
    p = tuple(values.T)
    after, _ = law.act(p, moment(), law.initial(p, jnp.asarray(Q), jnp.asarray(W)))
    before = JointForce(0.0, 0.0, 0.0, 0.0, 1.0)
    for x, y in zip(jax.tree.leaves(before), jax.tree.leaves(after), strict=True):
        np.testing.assert_array_equal(np.broadcast_to(y, len(Q)), np.full(len(Q), x))


@every_law
@pytest.mark.parametrize("name", ROBOTS)
def test_bounds_sentences_and_starts_go_together(law: JointLaw, name: str) -> None:
    subject = robot(name)
    for site in law.sites(subject):
        bounds = np.array(law.bounds(subject, site))
        assert bounds.shape == (len(law.parameters), 2) and np.isfinite(bounds).all()
        assert (bounds[:, 0] <= bounds[:, 1]).all() and bounds[0, 1] > 0.0
        assert (bounds[0, 0] < 0.0) == law.parameters[0].signed
        values = dict(zip([p.name for p in law.parameters], bounds @ [0.3, 0.7], strict=True))
        said = Change(law.name, site, values).sentence()
        assert site in said and any(c.isdigit() for c in said.replace(site, "")) and not said.endswith(".")
        assert law.formula(values)[:2] in ("+ ", "- ")
        spec = subject.spec.copy()
        with nullcontext() if law.in_mjcf else pytest.raises(NotImplementedError, match=law.name):
            law.write_mjcf(subject, spec, site, values)
        assert spec.compile().njnt == subject.model.njnt
    assert law.tried(REACH) and all(len(shape) == len(law.parameters) - 1 for shape in law.tried(REACH))
    assert law.equation and law.resembles and type(law).__doc__


@every_law
def test_a_joint_that_ran_away_does_not_ask_for_endless_starts(law: JointLaw) -> None:
    assert len(law.tried(REACH._replace(low=-1e8, high=1e8, speed=1e8))) < 200_000


@pytest.mark.parametrize(
    ("name", "p"),
    [
        ("law_stir", (0.05, 1.0)),
        ("law_tie", (0.3, 1.0, 0.1)),
        ("law_friction_wave", (0.03, 0.8, 5.0, 0.4)),
        ("law_driven", (0.3, 1.0)),
        ("law_late_command", (0.8, 0.05)),
        ("law_deaf_motor", (0.9, 0.1)),
        ("law_bristles", (0.2, 0.02)),
        ("law_inertia", (0.02,)),
        ("law_motor_brake", (0.1,)),
    ],
)
def test_engines_agree_on_laws(name: str, p: tuple[float, ...]) -> None:
    subject, rows = nominal("two"), 41
    law = effect(name)
    change = Change(law.name, "elbow", dict(zip([x.name for x in law.parameters], p, strict=True)))
    time = 0.01 * np.arange(rows)
    commands = np.stack([np.sin(9.0 * time), 0.4 * np.cos(7.0 * time)], axis=1)
    nothing = np.full((rows, 2), np.nan)
    recording = Recording("r", time, commands, np.ones((rows, 2)), nothing, nothing, nothing)
    stretch = window_of([recording], 0, (0, rows - 1), 0.005, InitialState(np.array([0.3, -0.2]), np.zeros(2)))
    effects = catalogue([name])
    values = stack([encode(subject, effects, [change]), encode(subject, effects, [])])
    found = [
        open_loop_simulator(subject, effects, [subject], engine=engine, width=2).replay(
            values, [stretch], np.zeros(2, int)
        )
        for engine in ("lanes", "mjx")
    ]
    np.testing.assert_allclose(found[0].qpos, found[1].qpos, atol=2e-5)
    assert np.abs(found[0].qpos[0] - found[0].qpos[1]).max() > 5e-3
