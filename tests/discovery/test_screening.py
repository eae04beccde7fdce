"""Which of many hypotheses are looked at longer."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from estexp_jax.discovery import screening
from estexp_jax.discovery.hypotheses import Free, Hypothesis
from estexp_jax.discovery.screening import looked_at, with_rungs
from estexp_jax.discovery.slopes import Fit


def _ranked(*effects: str) -> list[Fit]:
    return [Fit(Hypothesis(((name, "knee"),), ()), np.zeros(0), float(i)) for i, name in enumerate(effects)]


def _names(fits: list[Fit]) -> list[str]:
    return [f.hypothesis.places[-1][0] for f in fits]


def test_forms_of_one_effect_take_one_place() -> None:
    ranked = _ranked("outer_backlash", "cogging", "backlash", "viscous_friction", "armature")
    assert _names(with_rungs(ranked, 2)) == ["outer_backlash", "cogging", "backlash"]
    assert _names(with_rungs(ranked, 3)) == ["outer_backlash", "cogging", "backlash", "viscous_friction"]


def test_a_richer_law_brings_the_simpler_one_that_it_contains() -> None:
    ranked = _ranked("quadratic_drag", "cogging", "torque_offset", "viscous_friction")
    assert _names(with_rungs(ranked, 2)) == ["quadratic_drag", "cogging", "viscous_friction"]


def test_forms_at_other_sites_are_others() -> None:
    here, there = ("backlash", "knee"), ("outer_backlash", "hip")
    ranked = [Fit(Hypothesis((place,), ()), np.zeros(0), 0.0) for place in (here, there)]
    assert [f.hypothesis.places[-1] for f in with_rungs(ranked, 1)] == [here]


@pytest.mark.parametrize("value", [0.05, 0.3])
def test_what_is_bent_far_is_claimed_though_it_gains_little_beside_itself(
    monkeypatch: pytest.MonkeyPatch, value: float
) -> None:
    """A mass bent to its bound explains what claiming it would; another start is the model as it was."""
    mass, friction, drift = ("body_mass", "arm"), ("coulomb_friction", "shaft"), ("sensor_bias", "angle")
    bent = Free(*mass, "dm", 0, 0, -0.3, 0.3, 0.0, 0.03)
    motor = Free("motor_weakness", "servo", "loss", 0, 0, -0.3, 0.3, 0.0, 0.03)
    tasks = []
    for place in (friction, drift, mass):
        own = Free(*place, "x", 0, 0, -5.0, 5.0, 0.0, np.inf)
        tasks.append((Hypothesis((place,), (motor, own)), [np.array([0.1, 0.4])]))
    order, looks = (friction, drift, mass), list[int]()

    def fit(_: Any, again: Any, *__: Any, **___: Any) -> Any:
        yield
        looks.append(len(again))
        return [Fit(h, vectors[0], float(order.index(h.places[0]))) for h, vectors in again]

    monkeypatch.setattr(screening, "fit", fit)
    monkeypatch.setattr(screening, "slackened", lambda problem, *_: problem)
    monkeypatch.setattr(screening, "_telling", lambda problem, *_: problem.fitted)
    there: Any = SimpleNamespace(fitted=np.arange(4), slack=None)
    steps = looked_at(there, Fit(Hypothesis((), (motor, bent)), np.array([0.1, value]), 9.0), tasks, 9.0, "look", 1)
    with pytest.raises(StopIteration) as end:
        while True:
            next(steps)
    found = {h.places[0]: vectors for h, vectors in end.value.value}
    assert looks[0] == 3 and set(found) == ({friction, mass} if value == 0.3 else {friction})
    np.testing.assert_allclose(found[friction], [[0.1, 0.4]])
    if value == 0.3:
        np.testing.assert_allclose(found[mass], [[0.1, 0.4], [0.0, 0.4]])
