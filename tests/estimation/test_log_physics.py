"""Friction, damping, inertia, strength and mass explain what they make; a number of a fault is fitted beside them."""

import pytest

from estexp_jax.estimation.log_physics import fit_number, fit_physics
from estexp_jax.estimation.log_replay import log_replay_of
from estexp_jax.physics.effects.catalogue.command_lead import CommandLead
from tests.estimation.rubbing_servo import rubbing_log, servo
from tests.estimation.two_links import arm, faulty, log_of


@pytest.mark.parametrize("real", [{"friction": 0.1}, {"mass": 0.55}, {"damping": 0.45}])
def test_what_ordinary_physics_makes_it_explains(real):
    recording = log_of(arm(**real))
    replay = log_replay_of(arm(), recording)
    assert replay is not None
    [before] = replay.errors([recording])
    left = fit_physics(replay, recording)
    assert before > 3.0 * replay.floor and left < 2.0 * replay.floor and left < 0.3 * before


@pytest.mark.parametrize("real", [{"friction": 0.1}, {"damping": 0.45}])
@pytest.mark.parametrize("begin", [0.015, 0.045])
def test_a_number_is_found_beside_it_with_its_deviation(real, begin):
    robot, effect = arm(), CommandLead()
    late = faulty(robot, log_of(arm(**real)), "command_lead lead=0.03")
    replay = log_replay_of(robot, late)

    assert replay is not None

    def error_at(lead: float) -> float:
        return fit_physics(replay, effect.mended(robot, late, "", {"lead": lead}))

    found = fit_number(error_at, begin, 0.008, (0.0, 0.2), replay.count)
    assert found.value == pytest.approx(0.03, abs=0.004) and found.deviation < 0.005


@pytest.mark.parametrize(("begin", "wanted"), [(0.0, 0.3), (2.0, 0.3), (-1.5, 0.3)])
def test_the_least_error_is_found_from_afar(begin, wanted):
    found = fit_number(lambda v: (0.1 + (v - 0.3) ** 2) ** 0.5, begin, 0.5, (-2.0, 2.0), 100)
    assert found.value == pytest.approx(wanted, abs=0.03) and found.error == pytest.approx(0.1**0.5, rel=1e-2)
    assert found.deviation == pytest.approx((20.0 * 0.1 / 100) ** 0.5, rel=0.1)


def test_a_number_ends_at_its_bound():
    assert fit_number(lambda v: 2.0 - v, 0.5, 0.2, (0.0, 1.0), 100).value == 1.0


def test_friction_at_rest_does_not_end_the_fit_early():
    recording = rubbing_log(3, seconds=5.6)
    replay = log_replay_of(servo(), recording)
    assert replay is not None and replay.errors([recording])[0] > 5.0 * replay.floor
    assert fit_physics(replay, recording) < 2.0 * replay.floor
