"""A sensor that shows one value while its joint must move is seen; others are not."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from estexp_jax.discovery.diagnosis import ExplainConfig
from estexp_jax.discovery.hypotheses import parameters_only
from estexp_jax.discovery.location import where
from estexp_jax.discovery.selection import Selection
from estexp_jax.discovery.slopes import Fit
from estexp_jax.discovery.stuck_sensors import frozen
from estexp_jax.discovery.verdict import verdict
from tests.discovery.planted import Plant, case_of, problem_of


def looked_for(spoil) -> tuple[Any, Any, Any]:
    """What is found in recordings of a pendulum, spoilt before."""
    case = case_of("one", Plant(), 61)
    for recording in case.recordings:
        spoil(recording)
    problem = problem_of(case, ExplainConfig(window=1.25, effects=("sensor_stuck",)))
    parameters = parameters_only(case.robot, problem.replayer.catalogue)
    nominal = SimpleNamespace(fitted=Fit(parameters, parameters.start(), np.inf))
    selection: Any = SimpleNamespace(nominal=nominal)
    return case, nominal, frozen(problem, parameters, selection)


def still(recording, at: float = 0.3) -> None:
    recording.sensor[:] = at + 2e-4 * np.random.default_rng(62).standard_normal(recording.sensor.shape)


def test_a_reading_that_stays_while_the_joint_is_driven_is_a_stuck_sensor():
    case, nominal, found = looked_for(still)
    assert found.places == (("sensor_stuck", "angle"),)
    [claim] = found.claims
    assert claim.parameters["value"] == pytest.approx(0.3, abs=1e-3)
    selection = Selection(nominal, nominal, nominal, (found,), found, seen=True)
    assert verdict(case.robot, selection, found.claims) == "missing_physics"
    [place] = where(case.robot, selection)
    assert (place["kind"], place["name"], place["share"]) == ("sensor", "angle", 1.0) and place["p_value"] < 1e-80


def test_one_that_moves_is_none():
    assert looked_for(lambda recording: None)[2] is None


def test_nor_is_one_whose_joint_is_told_to_stay():
    def resting(recording) -> None:
        still(recording, 0.0)  # where it hangs
        recording.ctrl[:] = 0.0

    assert looked_for(resting)[2] is None
