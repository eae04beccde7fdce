"""The time step is blamed where it makes most of a plain mismatch, and only there."""

import numpy as np
import pytest

from estexp_jax.discovery.hypotheses import Hypothesis
from estexp_jax.discovery.numerics import step_entry, step_place, step_to_blame
from estexp_jax.discovery.selection import Explanation, Selection
from estexp_jax.discovery.slopes import Fit
from estexp_jax.report.explain_text import claim


def selection(nominal, corrected):
    """Errors of the nominal simulator as it steps and without its step's error."""
    fitted = Fit(Hypothesis((), ()), np.zeros(0), 0.0)
    as_it_is, finer = (Explanation(fitted, np.full(8, error**2 / 8)) for error in (nominal, corrected))
    return Selection(as_it_is, finer, finer, (), finer)


def test_a_plain_error_that_vanishes_with_the_step_is_the_steps():
    found = step_to_blame(selection(25.0, 1.1), nominal=0.03, timestep=0.01)
    assert found is not None
    assert found.place == "time_step"
    assert found.parameters["step"] == pytest.approx(0.01 / 25.0)
    entry, place = step_entry(found), step_place(selection(25.0, 1.1))
    assert (entry["effect"], entry["kind"], entry["name"]) == ("time_step", "numerics", None)
    assert place["kind"] == "numerics" and place["share"] > 0.99 and place["p_value"] < 0.01


def test_the_step_is_told_without_an_interval():
    found = step_to_blame(selection(25.0, 1.1), nominal=0.03, timestep=0.01)
    assert found is not None
    assert claim(step_entry(found)).endswith("(step = 0.0004 s; probability 100%).")


@pytest.mark.parametrize(("nominal", "corrected", "error"), [(25.0, 12.0, 0.03), (25.0, 1.1, 0.004)])
def test_an_error_that_stays_or_that_every_simulator_makes_is_not(nominal, corrected, error):
    assert step_to_blame(selection(nominal, corrected), error, 0.01) is None
