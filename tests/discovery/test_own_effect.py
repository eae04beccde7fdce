"""A user's effect is searched from its own guesses and from its simpler relative, is found, and gives its advice."""

from collections import Counter

import numpy as np
import pytest

from estexp_jax.discovery.diagnosis import ExplainConfig, explaining
from estexp_jax.discovery.hypotheses import claimable
from estexp_jax.effects import JointForce, Parameter, Term, Vectors, register, scalar_joint_sites, scales
from estexp_jax.physics.effects import registry
from tests.discovery.planted import Plant, case_of, explained, nominal

PEAK, CRITICAL = 0.25, 1.5
ASKED: Counter[str] = Counter()
ADVICE = "Record a motion at twice the speed: an eddy-current brake resists less there, viscous friction more."


class EddyBrake(Term):
    """tau = -2 T (w/w_c) / (1 + (w/w_c)^2)."""

    name, kind, source = "eddy_brake", "joint", "this test"
    equation = "tau = -2 T (w/w_c) / (1 + (w/w_c)^2)"
    parameters = (Parameter("T", "N m"), Parameter("w_c", "rad/s", 1.0))
    nested_in = "viscous_friction"

    def sites(self, robot):
        return scalar_joint_sites(robot)

    def bounds(self, robot, site):
        return (0.0, scales.joint_torque(robot, robot.index("joint", site))), (0.3, 30.0)

    def sentence(self, site, values):
        return f"a brake at {site} resists most, with {values['T']:.3g} N m, at {values['w_c']:.3g} rad/s"

    def initial_guesses(self, robot, site, observed) -> Vectors:
        ASKED["initial_guesses"] += 1
        low, high = observed.joint_range(robot, site)
        assert low < high
        return [(0.1 * self.bounds(robot, site)[0][1], w) for w in (0.5, 2.0, 8.0)]

    def from_simpler(self, simpler, bounds) -> Vectors:
        ASKED["from_simpler"] += 1
        return [(0.5 * simpler["c"] * w, w) for w in (1.0, 4.0)]

    def to_simpler(self, values) -> Vectors:
        return [(2.0 * values["T"] / values["w_c"],)]

    def advice(self, recordings):
        return (ADVICE,)

    def act(self, p, joint, state):
        peak, critical = p
        return JointForce(damping=2.0 * peak / critical / (1.0 + (joint.w / critical) ** 2)), state


@pytest.fixture(autouse=True)
def _registered(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry, "_EFFECTS", dict(registry._EFFECTS))
    register(EddyBrake, [nominal("one")])


def _brake(time: float, qpos: np.ndarray, qvel: np.ndarray) -> np.ndarray:
    w = qvel / CRITICAL
    return -2.0 * PEAK * w / (1.0 + w**2)


def test_it_is_found_from_its_own_guesses_and_its_advice_is_given() -> None:
    ASKED.clear()
    config = ExplainConfig(window=1.25, most=1, effects=("viscous_friction", "coulomb_friction", "eddy_brake"))
    found = explained(case_of("one", Plant(law=_brake), 61), config)
    [claim] = found.findings["what"]
    assert (claim["effect"], claim["name"]) == ("eddy_brake", "shaft") and claim["probability"] > 0.5
    assert claim["parameters"]["T"]["value"] == pytest.approx(PEAK, rel=0.1)
    assert claim["parameters"]["w_c"]["value"] == pytest.approx(CRITICAL, rel=0.15)
    assert ADVICE in found.findings["advice"]
    assert ASKED["initial_guesses"] and ASKED["from_simpler"]


def test_another_form_is_tried_wherever_the_effect_is_and_only_then() -> None:
    class Form(EddyBrake):
        name, nested_in, variant_of = "eddy_form", "", "eddy_brake"

    register(Form, [nominal("one")])
    assert "eddy_brake" in explaining() and "eddy_form" not in explaining()
    assert claimable(explaining()).count("eddy_form") == 1
    assert "eddy_form" not in claimable(["viscous_friction"])
