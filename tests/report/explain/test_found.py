"""Entries of findings as objects."""

from estexp_jax.report.explain.found import ClaimedNumber, claimed_effects, error_places, fit_errors
from tests.report.examples import FINDINGS


def test_every_entry_is_there_by_name() -> None:
    [one, other] = claimed_effects(FINDINGS)
    assert (one.effect, other.effect) == ("coulomb_friction", "load_dependent_friction")
    assert str(one) == "the joint resists motion with 1.02 N m (probability 94%)"
    assert error_places(FINDINGS)[0].share == 0.91
    fit = fit_errors(FINDINGS)
    assert fit.nominal == FINDINGS["fit"]["nominal"] and fit.gain_interval[0] == FINDINGS["fit"]["gain"]["low"]


def test_numbers_print_with_interval_and_unit() -> None:
    assert str(ClaimedNumber(0.5, None, 0.7, "s")) == "0.5 (? to 0.7) s"
    assert str(ClaimedNumber("knee", None, None, "")) == "knee"
