"""Effects of the user's own: what is refused, what registering gives."""

from typing import Any

import pytest

import estexp_jax as ee
from estexp_jax.errors import InputError
from estexp_jax.package_data import model_path
from estexp_jax.physics.effects import registry
from estexp_jax.physics.effects.base import Effect, JointForce, Parameter, Term
from estexp_jax.physics.effects.catalogue.quadratic_drag import QuadraticDrag
from estexp_jax.physics.effects.changes import Change, encode
from estexp_jax.physics.effects.sites import scalar_joint_sites
from estexp_jax.physics.model.robot import Robot

LEG = Robot.from_xml(model_path("leg"))


class _Drag(Term):
    """A law of one's own."""

    name, kind, equation, source = "my_drag", "joint", "tau = -c w^3", "this test"
    parameters = (Parameter("c", "N m s3/rad3"),)

    def sites(self, robot):
        return scalar_joint_sites(robot)

    def bounds(self, robot, site):
        return ((0.0, 1.0),)

    def sentence(self, site, values):
        return f"the joint {site} is slowed by {values['c']} N m at 1 rad/s"

    def act(self, p, joint, state):
        return JointForce(damping=p[0] * joint.w**2), state


@pytest.fixture(autouse=True)
def _none_yet(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry, "_EFFECTS", dict(registry._EFFECTS))


def _spoilt(**members: Any) -> Effect:
    return type("Spoilt", (_Drag,), members)()


def test_what_is_registered_is_known_everywhere() -> None:
    drag = ee.register(_Drag(), [LEG])
    assert registry.effect("my_drag") is drag and drag in registry.every()
    values = encode(LEG, (drag,), [Change("my_drag", "knee", {"c": 0.3})])["my_drag"]
    assert values.sum() == pytest.approx(0.3)
    again = ee.register(_Drag(), [LEG])
    assert registry.own() == (again,)


def test_a_class_is_registered_by_a_decorator() -> None:
    @ee.register
    class Mine(_Drag):
        name = "mine"

    assert isinstance(Mine, type) and isinstance(registry.effect("mine"), Mine)
    assert registry.named_effects()[-1].name == "mine", "after the catalogue"


def test_one_that_is_refused_leaves_the_earlier_one() -> None:
    drag = ee.register(_Drag(), [LEG])
    with pytest.raises(InputError, match="cannot be present"):
        ee.register(_spoilt(bounds=lambda self, robot, site: ((0.0, 0.0),)), [LEG])
    assert registry.own() == (drag,)


SPOILT = {
    "a lower-case identifier|no lower-case": {"name": "My Drag"},
    "no equation": {"equation": ""},
    "has the kind 'wheel'": {"kind": "wheel"},
    "has the side 'inside'": {"side": "inside"},
    "no source": {"source": ""},
    "two parameters of one name": {"parameters": (Parameter("c", ""), Parameter("c", ""))},
    "where no joint is": {"sites": lambda self, robot: ("elbow_grease",)},
    "names a place twice": {"sites": lambda self, robot: ("knee", "knee")},
    "one \\(low, high\\) a parameter": {"bounds": lambda self, robot, site: ()},
    "not finite or not in order": {"bounds": lambda self, robot, site: ((0.0, float("inf")),)},
    "not said to be signed": {"bounds": lambda self, robot, site: ((-1.0, 1.0),)},
    "cannot be present": {"bounds": lambda self, robot, site: ((0.0, 0.0),)},
    "says nothing of": {"sentence": lambda self, site, values: f"drag of {values['c']}"},
    "says no number": {"sentence": lambda self, site, values: f"drag at {site}"},
    "more than one clause": {"sentence": lambda self, site, values: f"{site} drags {values['c']}."},
    "names 'rust' in nested_in, which is no other effect": {"nested_in": "rust"},
    "names 'my_drag' in variant_of, which is no other effect": {"variant_of": "my_drag"},
    "starts a search at 'hip' from \\(\\); a finite number": {"initial_guesses": lambda self, robot, site, o: [()]},
    "starts a search at 'hip' from its neutral": {"initial_guesses": lambda self, robot, site, o: [(0.0,)]},
    "starts from 'viscous_friction' at 'hip' from": {
        "nested_in": "viscous_friction",
        "from_simpler": lambda self, simpler, bounds: [(float("nan"),)],
    },
    "gives 'viscous_friction' at 'hip' to start": {
        "nested_in": "viscous_friction",
        "to_simpler": lambda self, values: [(1.0, 2.0)],
    },
    "changes something at its neutral values": {"act": lambda self, p, m, s: (JointForce(force=p[0] + 1.0), s)},
    "cannot be used: TypeError": {"act": lambda self, p, m: JointForce()},
    "cannot be used: KeyError": {"sentence": lambda self, site, values: f"{site} {values['d']}"},
}


@pytest.mark.parametrize("told", SPOILT, ids=lambda told: told.replace(" ", "-"))
def test_what_breaks_a_law_is_refused_and_not_kept(told: str) -> None:
    with pytest.raises(InputError, match=told):
        ee.register(_spoilt(**SPOILT[told]), [LEG])
    assert not registry.own()


def test_a_class_of_no_known_moment_is_refused() -> None:
    class Nowhere(Effect):
        """Acts at no moment."""

        name, kind, equation, source = "nowhere", "joint", "x", "nobody"
        parameters = (Parameter("c", ""),)
        sites, bounds, sentence = _Drag.sites, _Drag.bounds, _Drag.sentence

    with pytest.raises(InputError, match="it is no Edit, Term"):
        ee.register(Nowhere(), [LEG])


def test_the_programs_own_names_are_taken() -> None:
    with pytest.raises(InputError, match="there is an effect 'quadratic_drag' already"):
        ee.register(_spoilt(name="quadratic_drag"))
    assert isinstance(registry.effect("quadratic_drag"), QuadraticDrag)


def test_what_is_not_registered_cannot_be_read_back(tmp_path) -> None:
    with pytest.raises(InputError, match="there is no effect 'my_drag'"):
        Change("my_drag", "knee", {"c": 0.3}).sentence()
    ee.register(_Drag(), [LEG])
    assert "knee" in Change("my_drag", "knee", {"c": 0.3}).sentence()
