"""Laws that every effect of the registry obeys, on every robot: a new effect gets them for nothing."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from mujoco import mjx

from estexp_jax.physics.changes import Change, encode, neutral, parse_change
from estexp_jax.physics.controllers import HIDDEN, decode, n_weights
from estexp_jax.physics.effects.base import (
    BodyPull,
    CommandLaw,
    CommandShift,
    Distortion,
    Edit,
    Effect,
    JointForce,
    JointMoment,
    ReadingShift,
    Term,
    neutral_values,
)
from estexp_jax.physics.effects.controller_fault import ControllerFault
from estexp_jax.physics.effects.sites import ALL_ALIKE
from estexp_jax.physics.registry import ALL, PAPER, catalogue, effect
from estexp_jax.physics.robot import Robot
from tests.physics.robots import MUTE, ROBOTS, robot

KINDS = {"joint", "actuator", "sensor", "body", "environment", "controller"}

every_effect = pytest.mark.parametrize("e", ALL, ids=lambda e: e.name)
every_robot = pytest.mark.parametrize("name", [*ROBOTS, MUTE])


def _sites(e: Effect, subject: Robot) -> list[str]:
    return list(e.sites(subject))


def _middle(e: Effect, subject: Robot, site: str) -> dict[str, float]:
    bounds = e.bounds(subject, site)
    return {p.name: low + 0.7 * (high - low) for p, (low, high) in zip(e.parameters, bounds, strict=True)}


def test_names_are_unique_and_the_papers_six_are_there() -> None:
    assert len({e.name for e in ALL}) == len(ALL)
    assert [e.name for e in catalogue(PAPER)] == list(PAPER)


@every_effect
def test_it_says_what_it_is(e: Effect) -> None:
    assert effect(e.name) is e
    assert e.kind in KINDS
    assert e.side in {"plant", "command", "sensor", "numerics"}
    assert e.equation and e.source
    assert e.parameters and len({p.name for p in e.parameters}) == len(e.parameters)
    assert type(e).__doc__


@every_effect
@every_robot
def test_sites_exist_in_the_robot(e: Effect, name: str) -> None:
    sites = _sites(e, robot(name))
    assert len(set(sites)) == len(sites)
    if e.kind == "environment":
        assert set(sites) <= {"", *robot(name).names("body")}
    elif e.kind == "controller":
        assert all(sites)
    else:
        assert set(sites) - {ALL_ALIKE} <= set(robot(name).names(e.kind))


@every_effect
def test_the_quadruped_has_a_place_for_it(e: Effect) -> None:
    assert _sites(e, robot("quadruped"))


@every_effect
@every_robot
def test_bounds_are_finite_ordered_and_one_per_parameter(e: Effect, name: str) -> None:
    for site in _sites(e, robot(name)):
        bounds = np.array(e.bounds(robot(name), site))
        assert bounds.shape == (len(e.parameters), 2)
        assert np.all(np.isfinite(bounds))
        assert np.all(bounds[:, 0] <= bounds[:, 1])
        for parameter, (low, _) in zip(e.parameters, bounds, strict=True):
            assert parameter.signed or low >= 0.0
            assert not parameter.refers or parameter.neutral == 0.0
        assert np.any(bounds != np.array([p.neutral for p in e.parameters])[:, None]), "it can be present"


@every_effect
@every_robot
def test_its_sentence_names_the_place(e: Effect, name: str) -> None:
    for site in _sites(e, robot(name)):
        change = Change(e.name, site or None, _middle(e, robot(name), site))
        said = change.sentence()
        assert site in said
        assert any(c.isdigit() for c in said.replace(site, "")) or e.name == "part_lost"
        assert "\n" not in said and not said.endswith(".")


@every_effect
@every_robot
def test_text_json_and_arrays_carry_a_change_assert_unchanged(e: Effect, name: str) -> None:
    subject = robot(name)
    for row, site in enumerate(_sites(e, subject)):
        change = Change(e.name, site or None, _middle(e, subject, site))
        text = " ".join([change.place, *(f"{k}={v!r}" for k, v in change.parameters.items())])
        assert parse_change(text, subject) == change
        assert Change.from_json(change.to_json()) == change
        assert change.to_json()["kind"] == e.kind
        values = encode(subject, ALL, [change])
        wanted = neutral(subject, ALL)
        wanted[e.name][row] = list(change.parameters.values())
        assert values.keys() == wanted.keys()
        for key in values:
            np.testing.assert_allclose(values[key], wanted[key], rtol=1e-6)


@every_effect
@every_robot
def test_neutral_values_change_nothing(e: Effect, name: str) -> None:
    subject = robot(name)
    sites = _sites(e, subject)
    values = jnp.asarray(neutral_values(e, len(sites)), jnp.float32).reshape(-1, len(e.parameters))
    _assert_unchanged(e, subject, values, exact=True)


def _assert_unchanged(e: Effect, subject: Robot, values: jax.Array, *, exact: bool) -> None:
    model = subject.model
    match e:
        case Edit():
            before: Any = mjx.put_model(model)
            after: Any = e.edit(subject, before, values)
        case Term():
            p, moment = tuple(values.T), _moment(len(values))
            before = JointForce(0.0, 0.0, 0.0, 0.0, 1.0)
            after, _ = e.act(p, moment, e.initial(p, moment.q, moment.w))
            before, after = jax.tree.map(lambda x: jnp.broadcast_to(x, len(values)), (before, after))
        case Distortion():
            before = jnp.arange(2.0 * model.nsensordata).reshape(2, -1)
            after = e.distort(subject, before, values)
        case ControllerFault():
            before = decode(jnp.linspace(-1.0, 1.0, n_weights(2, model.nu)), 2, model.nu)
            after = e.damage(subject, before, values)
        case CommandShift():
            before, after = np.zeros(model.nu), e.shift(subject, np.asarray(values))
        case ReadingShift():
            before, after = np.zeros(model.nsensordata), e.shift(subject, np.asarray(values))
        case CommandLaw():
            before = jnp.linspace(-1.0, 1.0, len(values))
            after, _ = e.act(tuple(values.T), before, 0.3 * before, 0.002, e.initial(tuple(values.T), before))
        case BodyPull():
            nothing, place = jnp.zeros(len(values)), jnp.ones(len(values))
            before, after = (nothing,) * 3, e.pull(tuple(values.T), (place, place, place))
        case _:
            raise AssertionError(f"{e.name} acts at no known moment")
    assert jax.tree.structure(before) == jax.tree.structure(after)
    for x, y in zip(jax.tree.leaves(before), jax.tree.leaves(after), strict=True):
        np.testing.assert_allclose(np.asarray(y), np.asarray(x), rtol=0.0 if exact else 1e-6)


def _moment(n: int) -> JointMoment:
    """Joints that move, pulled by springs as motors."""
    ones, q = jnp.ones(n), jnp.linspace(-1.0, 1.0, n)
    return JointMoment(q, 2.0 * ones, 3.0 - q, ones, 0.002, 5.0 * ones, 0.01 * ones, _spring, _other, _moved)


def _spring(q: jax.Array, w: jax.Array) -> jax.Array:
    return 3.0 - q - 0.1 * w


def _other(number: jax.Array) -> jax.Array:
    return 0.5 * number


def _moved(number: jax.Array) -> tuple[jax.Array, jax.Array]:
    return 0.2 * number, 0.3 * number


@pytest.mark.parametrize("e", [e for e in ALL if isinstance(e, Distortion)], ids=lambda e: e.name)
def test_restoring_undoes_a_distortion(e: Distortion) -> None:
    subject = robot("quadruped")
    true = np.random.default_rng(0).normal(size=(5, subject.model.nsensordata)).astype(np.float32)
    for site in e.sites(subject):
        values = encode(subject, (e,), [Change(e.name, site, _middle(e, subject, site))])[e.name]
        faulty = np.asarray(e.distort(subject, jnp.asarray(true), jnp.asarray(values)))
        column = subject.sensor_columns().index(site)
        others = np.arange(true.shape[1]) != column
        assert np.abs(faulty - true)[:, column].min() > 1e-3
        np.testing.assert_array_equal(faulty[:, others], true[:, others])
        if e.name == "sensor_stuck":
            true[:, column] = np.nan  # what is not seen cannot be restored
        np.testing.assert_allclose(e.restore(subject, faulty, values), true, atol=1e-6)


@pytest.mark.parametrize("e", [e for e in ALL if isinstance(e, Distortion)], ids=lambda e: e.name)
def test_a_distortion_scales_and_shifts_each_reading(e: Distortion) -> None:
    """Lanes rely on it: they work out both numbers once for a walk."""
    subject = robot("quadruped")
    changes = [Change(e.name, site, _middle(e, subject, site)) for site in e.sites(subject)]
    values = jnp.asarray(encode(subject, (e,), changes)[e.name])
    true = np.random.default_rng(1).normal(size=(5, subject.model.nsensordata)).astype(np.float32)
    shift, one = (np.asarray(e.distort(subject, jnp.full_like(true, x), values)) for x in (0.0, 1.0))
    faulty = np.asarray(e.distort(subject, jnp.asarray(true), values))
    assert np.abs(faulty - true).max() > 1e-3
    np.testing.assert_allclose(faulty, (one - shift) * true + shift, atol=1e-5)


def test_a_dead_sensor_cannot_be_restored() -> None:
    subject, e = robot("quadruped"), effect("sensor_gain")
    assert isinstance(e, Distortion)
    values = encode(subject, (e,), [parse_change("sensor_gain@touch_f gain=0", subject)])["sensor_gain"]
    true = e.restore(subject, np.ones((2, subject.model.nsensordata)), values)
    assert np.isnan(true[:, 0]).all() and np.isfinite(true[:, 1:]).all()


@pytest.mark.parametrize("e", ALL, ids=lambda e: e.name)
@every_robot
def test_it_writes_mjcf_if_and_only_if_it_says_so(e: Effect, name: str) -> None:
    subject = robot(name)
    for site in _sites(e, subject):
        spec = subject.spec.copy()
        values = _middle(e, subject, site)
        if e.in_mjcf:
            e.write_mjcf(subject, spec, site, values)
            spec.compile()
        else:
            with pytest.raises(NotImplementedError, match=e.name):
                e.write_mjcf(subject, spec, site, values)


def test_controller_faults_hit_their_neuron_and_motor_only() -> None:
    subject = robot("quadruped")
    network = decode(jnp.zeros(n_weights(8, 8)), 8, 8)
    fault, tie = effect("neuron_fault"), effect("tied_outputs")
    assert isinstance(fault, ControllerFault) and isinstance(tie, ControllerFault)
    values = encode(
        subject,
        (fault, tie),
        [parse_change(t, subject) for t in ("neuron_fault@hidden_1 gain=0.5", "tied_outputs@knee_f with=hip_r")],
    )
    gains = fault.damage(subject, network, jnp.asarray(values["neuron_fault"])).hidden_gain
    np.testing.assert_array_equal(gains, [1.0, 0.5, 1.0][:HIDDEN])
    motors = list(subject.names("actuator"))
    wanted = np.arange(8)
    wanted[motors.index("knee_f")] = motors.index("hip_r")
    np.testing.assert_array_equal(tie.damage(subject, network, jnp.asarray(values["tied_outputs"])).output_of, wanted)


def test_a_command_delay_is_never_negative() -> None:
    subject, e = robot("cartpole"), effect("command_delay")
    assert isinstance(e, CommandShift)
    shift = e.shift(subject, np.array([[[0.03]], [[-0.1]]]))
    np.testing.assert_allclose(shift, [[0.03], [0.0]], rtol=1e-6)
