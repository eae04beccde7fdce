"""What test recordings take back of claims."""

from typing import Any

import pytest

from estexp_jax.discovery.clock_doubt import MOST_PROBABLE
from estexp_jax.discovery.confirmation import confirmed

CLAIM = {
    "effect": "coulomb_friction",
    "kind": "joint",
    "name": "knee",
    "probability": 0.94,
    "sentence": "the knee rubs",
}
TILT = {"effect": "gravity_tilt", "kind": "environment", "name": None, "probability": 0.9, "sentence": "it is tilted"}


def _fit(low: float | None = 0.8, placebo: float | None = 0.05, explained: float = 0.01) -> dict[str, Any]:
    return {
        "gain": {"value": 0.9, "low": low, "high": 0.95},
        "placebo": {} if placebo is None else {"train": 0.0, "test": placebo},
        "explained": {"train": 0.01, "test": explained},
        "nominal": {"train": 0.5, "test": 0.6},
    }


def _other(*effects: str, error: float | None) -> dict[str, Any]:
    return {"effects": list(effects), "probability": 0.0, "test_error": error}


@pytest.mark.parametrize("placebo", [0.05, None])
def test_what_the_test_bears_out_stays_as_it_is(placebo: float | None):
    alternatives = [_other("armature@knee", error=0.03), _other("backlash@knee", error=None)]
    assert confirmed([CLAIM, TILT], _fit(placebo=placebo), alternatives) == [CLAIM, TILT]


@pytest.mark.parametrize("low", [0.0, -0.2, None])
def test_a_gain_whose_interval_holds_nothing_is_even_odds_at_most(low: float | None):
    [entry] = confirmed([CLAIM], _fit(low=low), [])
    assert entry["probability"] == MOST_PROBABLE
    assert entry["sentence"] == "the knee rubs; but the test recordings may be predicted no better with it"


def test_a_placebo_that_predicts_as_well_lowers_all():
    entries = confirmed([CLAIM, TILT], _fit(placebo=0.01), [])
    assert [e["probability"] for e in entries] == [MOST_PROBABLE, MOST_PROBABLE]
    assert all("a wrong effect predicts" in e["sentence"] for e in entries)


def test_a_rival_lowers_only_what_it_does_without():
    rival = _other("coulomb_friction@knee", "armature@knee", error=0.009)
    friction, tilt = confirmed([CLAIM, TILT], _fit(), [rival])
    assert friction == CLAIM
    assert tilt["probability"] == MOST_PROBABLE
    assert "coulomb_friction@knee with armature@knee predicts" in tilt["sentence"]
    assert confirmed([TILT], _fit(), [_other("gravity_tilt", error=0.0)]) == [TILT]


def test_refitted_values_are_a_rival():
    [entry] = confirmed([CLAIM], _fit(), [_other(error=0.01)])
    assert "a refit of the model's own values predicts" in entry["sentence"]


def test_it_never_raises_a_probability():
    [entry] = confirmed([{**CLAIM, "probability": 0.2}], _fit(low=0.0), [])
    assert entry["probability"] == 0.2


def test_a_test_that_shows_far_more_than_training_bears_nothing_out_unless_most_of_it_is_explained():
    fit = _fit(low=0.01, placebo=1.6, explained=1.5)
    fit["gain"]["high"] = 0.02
    [entry] = confirmed([CLAIM], fit, [])
    assert entry["probability"] == MOST_PROBABLE and "more is left on the test recordings" in entry["sentence"]
    larger = _fit(low=0.8, placebo=1.6, explained=1.5)  # a larger motion, most of whose error is gone
    assert confirmed([CLAIM], larger, []) == [CLAIM]
