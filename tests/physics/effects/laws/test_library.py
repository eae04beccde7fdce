"""Terms of unknown laws: nothing at amplitude zero, the force that their equation says, bounds and words that fit."""

from contextlib import nullcontext

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from estexp_jax.physics.effects.base import JointForce, Term, neutral_values
from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.effects.laws.base import JointLaw, MotionRange
from estexp_jax.physics.effects.laws.library import law_terms
from estexp_jax.physics.effects.registry import effect, named_effects, nameless, variants
from tests.physics.effects.laws.joint_states import ASKED, FASTER, M2, Q2, REMEMBERING, W2, M, Q, W, force, joint_state
from tests.physics.robots import ROBOTS, robot

every_law = pytest.mark.parametrize("law", law_terms(), ids=lambda law: law.name)
MOTION = MotionRange(-1.2, 1.4, 3.0, 8.0, 2.0, (1,))
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


def test_the_library_is_one_of_its_own() -> None:
    names = [e.name for e in (*named_effects(), *variants(), *law_terms(), *nameless())]
    assert len(set(names)) == len(names)
    assert {law.name for law in law_terms()} == {*EXPECTED, *REMEMBERING}
    assert {law.stands_for for law in law_terms()} - {""} <= {e.name for e in named_effects()}


@pytest.mark.parametrize("name", EXPECTED)
def test_the_force_is_what_the_equation_says(name: str) -> None:
    p, expected = EXPECTED[name]
    np.testing.assert_allclose(force(name, *p), expected, rtol=1e-4, atol=1e-5)


def test_a_motor_whose_supply_sags_gives_less_the_more_is_asked():
    sag, p = effect("law_sag"), (jnp.full(len(Q), 0.55),)
    assert isinstance(sag, Term) and sag.kind == "actuator"
    does, _ = sag.act(p, joint_state(), ())
    share = np.maximum(1.0 - 0.55 * np.abs(M), 0.0)
    assert share.min() == 0.0, "at the largest torques nothing is left"
    np.testing.assert_allclose(does.motor, share, atol=1e-6)
    for site in sag.sites(robot("quadruped")):
        assert "0.55 |m|" in sag.equation_with_values({"a": 0.55}) and site in sag.sentence(site, {"a": 0.55})


@every_law
def test_without_amplitude_nothing_changes(law: JointLaw) -> None:
    values = jnp.asarray(neutral_values(law, len(Q)), jnp.float32)
    assert law.parameters[0].neutral == 0.0
    p = tuple(values.T)
    after, _ = law.act(p, joint_state(), law.initial(p, jnp.asarray(Q), jnp.asarray(W)))
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
        if not law.in_mjcf or not law.mjcf_refusal(subject, site, values):
            with nullcontext() if law.in_mjcf else pytest.raises(NotImplementedError, match=law.name):
                law.write_mjcf(subject, spec, site, values)
        assert spec.compile().njnt == subject.model.njnt
    assert law.initial_shapes(MOTION) and all(
        len(shape) == len(law.parameters) - 1 for shape in law.initial_shapes(MOTION)
    )
    assert law.equation and law.resembles and type(law).__doc__


@every_law
def test_a_joint_that_ran_away_does_not_ask_for_endless_starts(law: JointLaw) -> None:
    assert len(law.initial_shapes(MOTION._replace(low=-1e8, high=1e8, speed=1e8))) < 200_000
