"""Laws that every effect of the registry obeys, on every robot: a new effect gets them for nothing."""

from collections.abc import Sequence

import jax.numpy as jnp
import numpy as np
import pytest

from estexp_jax.physics.effects.base import (
    CommandShift,
    Distortion,
    Effect,
)
from estexp_jax.physics.effects.changes import Change, encode, parse_change
from estexp_jax.physics.effects.checks import effect_faults, middle_values
from estexp_jax.physics.effects.controller_fault import ControllerFault
from estexp_jax.physics.effects.registry import effect, named_effects, nameless, paper
from estexp_jax.recovery.control.network import HIDDEN, decode, n_weights
from tests.physics.robots import BOLTED, MUTE, ROBOTS, robot

EVERY = (*named_effects(), *nameless())
every_effect = pytest.mark.parametrize("e", EVERY, ids=lambda e: e.name)


def quick(e: Effect, name: str) -> bool:
    """Whether an effect is tried on a robot by default: on those without a place for it, and on a cheap one with."""
    return name in ("pendulum", MUTE, BOLTED) or (name == "quadruped" and not e.sites(robot("pendulum")))


def on_every_robot(effects: Sequence[Effect]) -> pytest.MarkDecorator:
    """Each effect on each robot; most pairs are slow."""
    pairs = [(e, name) for name in (*ROBOTS, MUTE, BOLTED) for e in effects]
    marked = [
        pytest.param(e, name, id=f"{name}-{e.name}", marks=() if quick(e, name) else pytest.mark.slow)
        for e, name in pairs
    ]
    return pytest.mark.parametrize(("e", "name"), marked)


def test_names_are_unique_and_the_papers_six_are_there() -> None:
    assert len({e.name for e in named_effects()}) == len(named_effects())
    assert [e.gene for e in paper()] == list(range(6))


@every_effect
def test_it_says_what_it_is(e: Effect) -> None:
    assert effect(e.name) is e
    assert type(e).__doc__


@on_every_robot(EVERY)
def test_it_obeys_the_laws(e: Effect, name: str) -> None:
    assert effect_faults(e, robot(name)) == []


@every_effect
def test_some_robot_has_a_place_for_it(e: Effect) -> None:
    assert e.sites(robot("quadruped")) or e.sites(robot(BOLTED))


@pytest.mark.parametrize("e", [e for e in named_effects() if isinstance(e, Distortion)], ids=lambda e: e.name)
def test_restoring_undoes_a_distortion(e: Distortion) -> None:
    subject = robot("quadruped")
    true = np.random.default_rng(0).normal(size=(5, subject.model.nsensordata)).astype(np.float32)
    for site in e.sites(subject):
        values = encode(subject, (e,), [Change(e.name, site, middle_values(e, subject, site))])[e.name]
        faulty = np.asarray(e.distort(subject, jnp.asarray(true), jnp.asarray(values)))
        column = subject.sensor_columns().index(site)
        others = np.arange(true.shape[1]) != column
        assert np.abs(faulty - true)[:, column].min() > 1e-3
        np.testing.assert_array_equal(faulty[:, others], true[:, others])
        if e.name == "sensor_stuck":
            true[:, column] = np.nan  # what is not seen cannot be restored
        np.testing.assert_allclose(e.restore(subject, faulty, values), true, atol=1e-6)


@pytest.mark.parametrize("e", [e for e in named_effects() if isinstance(e, Distortion)], ids=lambda e: e.name)
def test_a_distortion_scales_and_shifts_each_reading(e: Distortion) -> None:
    """Lanes rely on it: they work out both numbers once for a walk."""
    subject = robot("quadruped")
    changes = [Change(e.name, site, middle_values(e, subject, site)) for site in e.sites(subject)]
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


@on_every_robot(named_effects())
def test_it_writes_mjcf_if_and_only_if_it_says_so(e: Effect, name: str) -> None:
    subject = robot(name)
    for site in e.sites(subject):
        spec = subject.spec.copy()
        values = middle_values(e, subject, site)
        if not e.mjcf_refusal(subject, site, values):
            assert e.in_mjcf
            e.write_mjcf(subject, spec, site, values)
            spec.compile()
        elif not e.in_mjcf:
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
    values = np.zeros((2, len(e.sites(subject)), 1))
    values[:, 0, 0] = 0.03, -0.1
    np.testing.assert_allclose(e.shift(subject, values)[:, 0], [0.03, 0.0], rtol=1e-6)


def test_a_spring_to_a_far_point_is_told_as_a_constant_force() -> None:
    pull = effect("external_force")
    spring = {"x": 0.39, "y": 0.0, "z": 0.0, "k": 2.0}
    assert pull.sentence("cart", spring) == "a spring of 2 N/m pulls the body cart towards (0.195, 0, 0) m"
    assert pull.sentence("cart", spring | {"k": 0.002}) == "a force of (0.39, 0, 0) N acts on the body cart"
