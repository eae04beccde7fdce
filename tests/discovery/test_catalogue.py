"""Every effect concealed in the leg is named, by the whole catalogue (slow: minutes a case)."""

from unittest.mock import patch

import numpy as np
import pytest

from estexp_jax.discovery import comparison
from estexp_jax.discovery.diagnosis import ExplainConfig, explaining
from estexp_jax.discovery.explain import explain
from estexp_jax.discovery.hypotheses import claimable
from estexp_jax.package_data import model_path
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import Catalogue, effect, every, logging_faults
from estexp_jax.physics.engines.choice import open_loop_simulator
from estexp_jax.physics.engines.open_loop import OpenLoopSimulator
from estexp_jax.physics.model.robot import Robot
from tests.discovery.leg import CASES, JOINTS, leg_case
from tests.discovery.planted import finished
from tests.physics.robots import ROBOTS, robot

CONFIG = ExplainConfig(window=2.0, most=1)
REPLAYERS: dict[tuple[float, tuple[str, ...]], OpenLoopSimulator] = {}


def _shared(leg: Robot, effects: Catalogue, *_: object, **__: object) -> OpenLoopSimulator:
    """One replayer, so one compilation, for all cases of a leg with these effects."""
    key = float(leg.model.actuator_forcerange[0, 1]), tuple(e.name for e in effects)
    if key not in REPLAYERS:
        REPLAYERS[key] = open_loop_simulator(leg, effects, [leg])
    return REPLAYERS[key]


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_a_concealed_effect_is_named(case: str) -> None:
    with patch.object(comparison, "open_loop_simulator", _shared):
        found = finished(explain(leg_case(case, 900), CONFIG)).findings
    assert f"{found['what'][0]['effect']}@{found['what'][0]['name']}" in (case, f"{case}@None")


def test_the_whole_catalogue_is_concealed_somewhere() -> None:
    planted = {case.partition("@")[0] for case in CASES}
    elsewhere = {"ground_friction", "mount_compliance"}  # the leg touches nothing, and no body of it is welded
    elsewhere |= {e.name for e in logging_faults()}  # in logs of an arm: test_log_mending.py
    assert planted == set(explaining()) - elsewhere
    assert set(JOINTS) == set(Robot.from_xml(model_path("leg")).names("joint"))


@pytest.mark.parametrize("name", claimable(explaining()))
def test_searches_start_where_the_effect_is_present(name: str) -> None:
    e = effect(name)
    for subject in map(robot, ROBOTS):
        nq, n = subject.model.nq, subject.model.nsensordata
        seen = Observed(np.full(nq, -0.5), np.full(nq, 0.7), np.full(n, 0.1))
        for site in e.sites(subject):
            found = e.initial_guesses(subject, site, seen)
            assert len(found) == len(set(found)) and len(found) > 0 or subject.model.nu == 1
            for values in found:
                assert len(values) == len(e.parameters) and np.isfinite(values).all()
                assert values != tuple(p.neutral for p in e.parameters)


@pytest.mark.parametrize("grip", [0.4, 1.3])
def test_a_grip_starts_a_little_on_either_side_of_the_modelled_one(grip: float) -> None:
    """Where feet slip a hair less the robot goes another way, from which no fit finds back."""
    ground = f'<mujoco><worldbody><geom type="plane" size="1 1 1" friction="{grip}"/><body><freejoint/>'
    walker = Robot.from_string(ground + '<geom size=".1" friction=".1"/></body></worldbody></mujoco>', "walker.xml")
    nothing = Observed(np.zeros(7), np.zeros(7), np.zeros(0))
    found = np.array(effect("ground_friction").initial_guesses(walker, "", nothing)).ravel()
    off = found / grip - 1.0
    assert 0.02 < off[off > 0].min() < 0.1 and -0.1 < off[off < 0].max() < -0.02
    assert found.min() < 0.1 * grip and found.max() > 1.3 * grip


def test_richer_laws_start_from_simpler_ones() -> None:
    amounts = {"T": 0.5, "sigma": 250.0, "loss": 0.3, "c": 0.1, "dm": 0.1, "delay": 0.01, "I": 0.01, "tau": 2.0}
    amounts |= {"low": -1.0, "high": 1.0, "half_gap": 0.05, "R": 0.02, "a": 0.2}
    for richer in (e for e in every() if e.nested_in):
        simpler = effect(richer.nested_in)
        assert richer.kind == simpler.kind or richer.name == "external_force"
        own = {p.name: amounts[p.name] for p in simpler.parameters}
        for values in richer.from_simpler(own, [(0.1, 0.7)] * len(richer.parameters)):
            assert len(values) == len(richer.parameters)


def test_simpler_laws_start_from_richer_ones() -> None:
    for richer in (e for e in every() if e.nested_in):
        for values in richer.to_simpler({p.name: 0.5 for p in richer.parameters}):
            assert len(values) == len(effect(richer.nested_in).parameters) and np.isfinite(values).all()
    levels = {"T": 0.4, "S": 0.2, "w_s": 0.3, "x": 0.01}
    assert effect("stribeck_friction").to_simpler(levels) == [(0.4,), (0.5,), pytest.approx((0.6,))]
    assert effect("stribeck_bristles").to_simpler(levels)[0] == (0.4, 40.0)
