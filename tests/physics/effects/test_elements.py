"""Effects at elements: each one's own values and those of all alike add up, and engines agree on what they do."""

from functools import cache

import jax.numpy as jnp
import numpy as np
import pytest

from estexp_jax.physics.effects.base import CommandLaw, Term
from estexp_jax.physics.effects.changes import Change, encode
from estexp_jax.physics.effects.elements import element_values, elements_of
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.effects.sites import ALL_ALIKE
from estexp_jax.physics.recording import Recording
from estexp_jax.physics.window import InitialState, window_of
from tests.physics.effects.laws.test_engines import ENGINES, replayed
from tests.physics.effects.test_alike import chain
from tests.physics.effects.test_twins import ROBOT

SETS: dict[str, list[Change]] = {
    "nominal": [],
    "sag": [Change("supply_sag", None, {"R": 0.12})],
    "floor": [Change("supply_floor", None, {"R": 0.12, "floor": 0.7})],
    "limit": [Change("command_limit", "servo", {"v": 0.8, "a": 8.0})],
    "speed alone": [Change("command_limit", "servo", {"v": 0.8})],
    "lags": [Change("actuator_lag", ALL_ALIKE, {"tau": 0.05}), Change("actuator_lag", "servo", {"tau": 0.03})],
    "each lag": [Change("actuator_lag", "push", {"tau": 0.05}), Change("actuator_lag", "servo", {"tau": 0.08})],
    "light": [Change("gravity_compensation", ALL_ALIKE, {"share": 0.8})],
    "each light": [Change("gravity_compensation", joint, {"share": 0.8}) for joint in ("shoulder", "elbow")],
    "one way": [Change("asymmetric_friction", "shoulder", {"T": 0.2, "a": 0.6})],
    "smooth": [Change("smooth_friction", "elbow", {"T": 0.1, "a": -0.4, "w_0": 0.5})],
    "valve": [Change("asymmetric_damping", "elbow", {"c": 0.06, "a": 0.5})],
}


@cache
def moved() -> dict[str, dict[str, np.ndarray]]:
    """Positions (rows, joints) of the two links under each set of changes, by engine."""
    rows = 81
    time = 0.01 * np.arange(rows)
    commands = np.repeat(np.random.default_rng(5).uniform(-0.9, 0.9, (9, 2)), 9, axis=0)
    nothing, on = np.full((rows, 2), np.nan), np.ones((rows, 2))
    on[40:50, 0] = 0.0
    recording = Recording("r", time, commands, on, nothing, nothing, nothing)
    window = window_of([recording], 0, (0, rows - 1), 0.0025, InitialState(np.array([0.4, -0.3]), np.zeros(2)))
    names = list(dict.fromkeys(change.effect for changes in SETS.values() for change in changes))
    found = replayed(ROBOT, names, window, list(SETS.values()))
    return {engine: dict(zip(SETS, qpos, strict=True)) for engine, qpos in found.items()}


@pytest.mark.parametrize("text", list(SETS))
def test_engines_agree(text: str) -> None:
    for engine in ENGINES:
        np.testing.assert_allclose(moved()[engine][text], moved()["c"][text], atol=5e-4)
    if text != "nominal":
        assert np.abs(moved()["c"][text] - moved()["c"]["nominal"]).max() > 5e-3


@pytest.mark.parametrize(("alike", "each"), [("lags", "each lag"), ("light", "each light")])
def test_all_alike_is_each_of_them(alike: str, each: str) -> None:
    for engine in ENGINES:
        np.testing.assert_allclose(moved()[engine][alike], moved()[engine][each], atol=1e-4)


def test_the_environment_stands_for_all_motors() -> None:
    sag = effect("supply_sag")
    assert isinstance(sag, Term)
    assert elements_of(sag, ROBOT) == ("servo", "push")
    assert sag.dofs(ROBOT).tolist() == [0, 1] and (motors := sag.motors(ROBOT)) is not None
    assert motors.tolist() == [0, 1]
    values = encode(ROBOT, (sag,), [Change("supply_sag", None, {"R": 0.25})])["supply_sag"]
    np.testing.assert_array_equal(element_values(sag, ROBOT, values), [[0.25], [0.25]])


@pytest.mark.parametrize("kind", [np.asarray, jnp.asarray])
def test_distances_from_neutral_add_up(kind) -> None:
    limit = effect("command_limit")
    assert isinstance(limit, CommandLaw) and limit.actuators(ROBOT).tolist() == [0]
    lag = effect("actuator_lag")
    values = kind(np.array([[[0.01], [0.0], [0.03]], [[0.01], [0.02], [0.0]]], np.float32))
    found = np.asarray(element_values(lag, ROBOT, values))
    np.testing.assert_allclose(found[..., 0], [[0.04, 0.03], [0.01, 0.02]], rtol=1e-6)
    assert found.dtype == np.float32


def test_a_limit_of_all_alike_is_not_lost_in_what_stands_for_none() -> None:
    robot, limit = chain("hinge", "hinge"), effect("command_limit")
    values = encode(robot, (limit,), [Change("command_limit", ALL_ALIKE, {"v": 1.3})])["command_limit"]
    never = limit.parameters[0].neutral
    np.testing.assert_allclose(element_values(limit, robot, values), [[1.3, never]] * 2, rtol=1e-6)
