"""Friction that is asymmetric or sets in gradually: its forms, and how they are told."""

import jax.numpy as jnp
import numpy as np
import pytest

from estexp_jax.physics.effects.catalogue.asymmetric_damping import AsymmetricDamping
from estexp_jax.physics.effects.catalogue.asymmetric_friction import AsymmetricFriction
from estexp_jax.physics.effects.catalogue.coulomb_friction import CoulombFriction
from estexp_jax.physics.effects.catalogue.smooth_friction import SmoothFriction
from estexp_jax.physics.effects.catalogue.viscous_friction import ViscousFriction
from estexp_jax.physics.effects.checks import effect_faults, sample_joint_state
from tests.physics.robots import robot

W = np.array([-3.0, -0.4, -0.05, 0.05, 0.4, 3.0])
FORMS = (AsymmetricFriction(), SmoothFriction(), AsymmetricDamping())


def torque(term, *p: float) -> np.ndarray:
    """At speeds `W`; a friction loss counts as what slides."""
    joint = sample_joint_state(len(W))._replace(w=jnp.asarray(W))
    does, _ = term.act(tuple(jnp.full(len(W), x) for x in p), joint, ())
    return np.asarray(-does.damping * W - does.friction * np.sign(W), float)


def test_each_is_its_equation() -> None:
    s = np.sign(W)
    np.testing.assert_allclose(torque(AsymmetricFriction(), 0.5, 0.2), -0.5 * (1 + 0.2 * s) * s, rtol=1e-3)
    np.testing.assert_allclose(torque(AsymmetricDamping(), 0.5, 0.2), -0.5 * (1 + 0.2 * s) * W, rtol=1e-5)
    np.testing.assert_allclose(
        torque(SmoothFriction(), 0.5, 0.2, 0.3), -0.5 * (1 + 0.2 * s) * np.tanh(W / 0.3), rtol=1e-5
    )


@pytest.mark.parametrize("form", FORMS, ids=lambda e: e.name)
@pytest.mark.parametrize("name", ["pendulum", "quadruped"])
def test_forms_obey_the_laws_of_effects(form, name: str) -> None:
    assert effect_faults(form, robot(name)) == []


def test_a_shape_is_told_where_there_is_one() -> None:
    name, values = SmoothFriction().reported_as({"T": 0.25, "a": 0.001, "w_0": 0.17})
    assert (name, values) == ("coulomb_friction", {"T": 0.25, "w_0": 0.17})
    dry = CoulombFriction()
    said = "the joint j resists motion with 0.25 N m, setting in gradually up to some 0.17 rad/s"
    assert dry.sentence("j", values) == said
    assert dry.equation_with_values(values) == "tau = -T tanh(w / w_0)"
    assert dry.equation_with_values({"T": 1.0}) == dry.equation
    name, values = AsymmetricDamping().reported_as({"c": 0.5, "a": -0.2})
    assert (name, values) == ("viscous_friction", {"c": 0.5, "a": -0.2})
    said = ViscousFriction().sentence("j", values)
    assert said.endswith("for each rad/s of speed, 20 % more backwards and as much less forwards")
    assert ViscousFriction().equation_with_values(values) == "tau = -c (1 + a sign(w)) w"
    assert AsymmetricFriction().reported_as({"T": 0.5, "a": 0.01})[1] == {"T": 0.5}
