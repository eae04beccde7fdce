"""Law terms made of named effects: the effect's physics at a joint, and nothing of it written again."""

import jax.numpy as jnp
import numpy as np
import pytest

from estexp_jax.physics.effects.base import Edit, JointForce
from estexp_jax.physics.effects.catalogue.actuator_lag import ActuatorLag
from estexp_jax.physics.effects.catalogue.cogging import Cogging
from estexp_jax.physics.effects.changes import Change, encode
from estexp_jax.physics.effects.laws.base import AmplitudeOnly
from estexp_jax.physics.effects.laws.from_effect import EffectLaw
from estexp_jax.physics.effects.laws.library import law_terms
from estexp_jax.physics.effects.registry import catalogue, effect
from estexp_jax.physics.engines.mjx.model import mjx_model
from tests.physics.effects.laws.joint_states import Q, joint_state
from tests.physics.robots import robot

FROM_EFFECTS = [law for law in law_terms() if isinstance(law, EffectLaw)]
every_one = pytest.mark.parametrize("law", FROM_EFFECTS, ids=lambda law: law.name)
FIELDS = {"damping": "dof_damping", "friction": "dof_frictionloss", "inertia": "dof_armature"}
"""What a field of a term's force adds to, in the model."""


class Ripple(AmplitudeOnly, EffectLaw, effect=Cogging):
    """A term that states no physics."""

    name = "ripple"
    resembles = "a ripple"

    def formula(self, values):
        return "+ 0"


def test_exactly_the_terms_that_stand_for_an_effect_are_made_of_one() -> None:
    assert [law.name for law in law_terms() if law.stands_for] == [law.name for law in FROM_EFFECTS]
    assert all(effect(law.stands_for).name == law.effect.name for law in FROM_EFFECTS)


def test_what_a_term_does_not_state_is_the_effects() -> None:
    law, cogging, p = Ripple(), Cogging(), tuple(jnp.full(len(Q), x) for x in (0.3, 5.0, 0.2))
    assert (law.parameters, law.equation, law.stands_for) == (cogging.parameters, cogging.equation, "cogging")
    [does, _], [expected, _] = law.act(p, joint_state(), ()), cogging.act(p, joint_state(), ())
    np.testing.assert_array_equal(does.force, expected.force)
    assert np.abs(np.asarray(does.force)).max() > 0.1


def test_a_term_made_of_an_effect_without_a_force_has_to_state_one() -> None:
    class Silent(AmplitudeOnly, EffectLaw, effect=ActuatorLag):
        name = "silent"

        def formula(self, values):
            return "+ 0"

    with pytest.raises(AssertionError, match="silent has to state its force"):
        Silent().act((jnp.zeros(len(Q)),), joint_state(), ())
    assert not Silent.in_mjcf, "MJCF has a place for it at the actuator, and the term is at the joint"


@pytest.mark.parametrize("law", [law for law in FROM_EFFECTS if law.adds_to], ids=lambda law: law.name)
def test_a_term_adds_what_the_effect_adds_to_the_model(law: EffectLaw) -> None:
    subject, e, parameter = robot("cartpole"), law.effect, law.parameters[0].name
    assert isinstance(e, Edit)
    does, _ = law.act((jnp.float32(0.25),), joint_state(), ())
    assert does == JointForce()._replace(**{law.adds_to: jnp.float32(0.25)})
    on, sites = mjx_model(subject, catalogue([e.name])), law.sites(subject)
    edited = on.edited(on.model, encode(subject, on.catalogue, [Change(e.name, sites[0], {parameter: 0.25})]))
    for field in FIELDS.values():
        gained = np.asarray(getattr(edited, field)) - np.asarray(getattr(on.model, field))
        np.testing.assert_allclose(gained[0], 0.25 * (field == FIELDS[law.adds_to]), atol=1e-6)


def _values(law: EffectLaw) -> dict[str, float]:
    return {p.name: 1.0 if p.refers else 0.2 for p in law.parameters}


@every_one
def test_a_term_stands_in_mjcf_where_its_effect_does(law: EffectLaw) -> None:
    subject = robot("cartpole")
    same = {p.name for p in law.effect.parameters} == set(law.effect_values(_values(law)))
    assert law.in_mjcf == (law.effect.in_mjcf and law.effect.kind == "joint" and same)
    site = law.sites(subject)[0]
    if not law.mjcf_refusal(subject, site, _values(law)):
        written = [subject.spec.copy() for _ in range(2)]
        for e, spec, values in zip(
            (law, law.effect), written, (_values(law), law.effect_values(_values(law))), strict=True
        ):
            e.write_mjcf(subject, spec, site, values)
            spec.compile()
        assert written[0].to_xml() == written[1].to_xml() != subject.spec.to_xml()
