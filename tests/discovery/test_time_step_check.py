"""The time step is blamed where it makes most of a plain mismatch, and only there."""

import numpy as np
import pytest

from estexp_jax.discovery.hypotheses import Hypothesis
from estexp_jax.discovery.selection import Explanation, Selection
from estexp_jax.discovery.slopes import Fit
from estexp_jax.discovery.time_step_check import Step, to_blame
from estexp_jax.report.explain.text import claim


def leaving(error):
    """Anything that leaves so many deviations, the same in eight windows."""
    return Explanation(Fit(Hypothesis((), ()), np.zeros(0), 0.0), np.full(8, error**2 / 8))


def selection(nominal, corrected):
    """Errors of the nominal simulator as it steps and without its step's error."""
    return Selection(leaving(nominal), leaving(corrected), leaving(corrected), (), leaving(corrected))


def test_a_plain_error_that_vanishes_with_the_step_is_the_steps():
    step = Step(0.004, leaving(0.8), leaving(24.0))
    assert to_blame(step, selection(25.0, 1.1), nominal=0.03)
    entry, place = step.entry(), step.place()
    assert (entry["effect"], entry["kind"], entry["name"]) == ("time_step", "numerics", None)
    assert entry["parameters"]["step"]["value"] == pytest.approx(0.004 / 30.0)
    assert place["kind"] == "numerics" and place["share"] > 0.99 and place["p_value"] < 0.01


def test_the_step_is_told_without_an_interval():
    step = Step(0.004, leaving(0.8), leaving(8.0))
    assert claim(step.entry()).endswith("(step = 0.0004 s; probability 100%).")


@pytest.mark.parametrize(("nominal", "corrected", "error"), [(25.0, 12.0, 0.03), (25.0, 1.1, 0.004)])
def test_an_error_that_stays_or_that_every_simulator_makes_is_not(nominal, corrected, error):
    assert not to_blame(Step(0.004, leaving(0.8), leaving(24.0)), selection(nominal, corrected), error)


@pytest.mark.parametrize(("stepped", "blamed"), [(2.4, True), (1.4, False)])
def test_a_longer_step_than_robots_have_is_blamed_for_less(stepped, blamed):
    assert to_blame(Step(0.01, leaving(0.8), leaving(stepped)), selection(25.0, 20.0), nominal=0.004) == blamed
