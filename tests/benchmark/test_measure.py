"""The bench checks engines before it times them, and times what it says; nothing here asserts a speed."""

import numpy as np
import pytest

from estexp_jax.benchmark import measure as module
from estexp_jax.benchmark.engines import C_ENGINES, Runner
from estexp_jax.benchmark.measure import BenchConfig, measure, timed
from estexp_jax.benchmark.subject import BenchmarkRobots
from estexp_jax.errors import InputError
from tests.benchmark.fake import Fake

SHARED = ("model", "population", "steps", "engines")
ENGINE = ("name", "robot_steps_per_s", "ratio_to_serial", "compile_s", "first_result_s", "peak_mb")


def test_an_engine_that_disagrees_is_not_timed(race, progress, monkeypatch) -> None:
    monkeypatch.setattr(module, "alone", lambda name, race: {"compile_s": 1.0, "first_result_s": 0.1, "peak_mb": 9.0})
    wrong = {"mjx": Fake("mjx", 0.1), "batch": Fake("batch", np.nan)}

    def made(name: str, field: BenchmarkRobots) -> Runner:
        if name == "lanes":
            raise InputError("a spring is not supported by the lanes engine")
        return wrong.get(name) or Fake(name)

    config = BenchConfig(race.model, population=5, steps=6, substeps=(2,), repeats=2, sweep=True)
    result = measure(config, progress, made)
    entries = {e["name"]: e for e in result["engines"]}
    for name in wrong:
        assert "differs from plain MuJoCo" in entries[name]["refused"]
        assert entries[name]["robot_steps_per_s"] is None and wrong[name].walks == []
    assert entries["lanes"]["refused"] == "a spring is not supported by the lanes engine"
    for name in ("serial", "serial_open", "rollout"):
        assert entries[name]["refused"] is None and entries[name]["robot_steps_per_s"] > 0.0
    assert "estimation" not in result and result["sweep"] == []


def test_all_engines_agree_and_the_result_has_what_the_specification_names(race, progress, monkeypatch) -> None:
    asked = []
    measured = {"compile_s": 1.0, "first_result_s": 0.1, "peak_mb": 9.0}
    monkeypatch.setattr(module, "alone", lambda name, race: asked.append(name) or measured)
    config = BenchConfig(race.model, population=5, steps=6, substeps=(2,), repeats=2, estimation=False)
    result = measure(config, progress)
    assert all(key in result for key in SHARED) and result["substeps"] == 2 and result["also"] == []
    assert asked == [*C_ENGINES, "mjx", "lanes"] == [e["name"] for e in result["engines"]]
    for entry in result["engines"]:
        assert all(entry[key] is not None for key in ENGINE), entry
        assert entry["agreement"]["agrees"] and len(entry["rates"]) == 2
        assert entry["robots"] == 5 and entry["steps"] == 6
    serial, lanes = result["engines"][0], result["engines"][-1]
    assert serial["ratio_to_serial"] == 1.0
    assert lanes["ratio_to_serial"] == lanes["robot_steps_per_s"] / serial["robot_steps_per_s"]
    assert lanes["flops_per_robot_step"] > 100.0 and lanes["fast"] is True


def test_engines_are_timed_in_turns(progress) -> None:
    order: list[str] = []

    class Loud(Fake):
        def simulate(self, robots: int, steps: int) -> None:
            order.append(self.name)

    fakes = [Loud(name) for name in "abc"]
    progress.stage("timing")
    rates, busy, peak = timed(fakes, 2, 3, progress)
    assert "".join(order) == "abc" * 4  # the first round warms up
    assert all(len(rates[name]) == len(busy[name]) == 3 for name in "abc") and peak > 0.0


def test_the_shipped_steps_and_one_are_the_races() -> None:
    assert [r.substeps for r in BenchConfig().races()] == [4, 1]
    assert [r.substeps for r in BenchConfig(substeps=(2, 2)).races()] == [2]


def test_feet_need_the_quadruped(race) -> None:
    with pytest.raises(InputError, match="--feet"):
        BenchConfig(race.model, feet=True).races()
