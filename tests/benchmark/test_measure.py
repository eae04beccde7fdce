"""The bench checks engines before it times them, and times what it says; nothing here asserts a speed."""

import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from estexp_jax.benchmark import measure as module
from estexp_jax.benchmark.engines import C_ENGINES, CRunner, Runner, runner
from estexp_jax.benchmark.measure import BenchConfig, bench, timed
from estexp_jax.benchmark.process import alone, peak_mb
from estexp_jax.benchmark.subject import BenchmarkRobots, BenchmarkTask, load
from estexp_jax.benchmark.sweep import sweep
from estexp_jax.errors import InputError
from estexp_jax.physics.engines.agreement import Agreement, engine_agreement
from estexp_jax.runs import ProgressDisplay
from tests.physics.robots import CARTPOLE, PENDULUM

SHARED = ("model", "population", "steps", "engines")
ENGINE = ("name", "robot_steps_per_s", "ratio_to_serial", "compile_s", "first_result_s", "peak_mb")


@pytest.fixture(scope="module")
def race(tmp_path_factory) -> BenchmarkTask:
    path = tmp_path_factory.mktemp("model") / "cartpole.xml"
    path.write_text(CARTPOLE)
    return BenchmarkTask(str(path), population=5, steps=6, substeps=2)


@pytest.fixture
def progress():
    with ProgressDisplay(out=io.StringIO(), err=io.StringIO()) as progress:
        yield progress


class Fake(Runner):
    """An engine that says how wrong it is."""

    def __init__(self, name: str, error: float = 0.0) -> None:
        self.name, self.robots, self.steps, self.error, self.walks = name, 3, 6, error, []

    def walk(self, robots: int, steps: int) -> None:
        self.walks.append((robots, steps))

    def agreement(self) -> Agreement:
        return engine_agreement(np.full((4, 2), self.error), np.zeros((4, 2)), 2)


def test_an_engine_that_disagrees_is_not_timed(race, progress, monkeypatch) -> None:
    monkeypatch.setattr(module, "alone", lambda name, race: {"compile_s": 1.0, "first_result_s": 0.1, "peak_mb": 9.0})
    wrong = {"mjx": Fake("mjx", 0.1), "batch": Fake("batch", np.nan)}

    def made(name: str, field: BenchmarkRobots) -> Runner:
        if name == "lanes":
            raise InputError("a spring is not supported by the lanes engine")
        return wrong.get(name) or Fake(name)

    config = BenchConfig(race.model, population=5, steps=6, substeps=(2,), repeats=2, sweep=True)
    result = bench(config, progress, made)
    entries = {e["name"]: e for e in result["engines"]}
    for name in wrong:
        assert "differs from the converged C engine" in entries[name]["refused"]
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
    result = bench(config, progress)
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
        def walk(self, robots: int, steps: int) -> None:
            order.append(self.name)

    fakes = [Loud(name) for name in "abc"]
    progress.stage("timing")
    rates, busy, peak = timed(fakes, 2, 3, progress)
    assert "".join(order) == "abc" * 4  # the first round warms up
    assert all(len(rates[name]) == len(busy[name]) == 3 for name in "abc") and peak > 0.0


def test_c_by_another_route_that_does_something_else_is_found(race) -> None:
    field = BenchmarkRobots(race)
    assert CRunner("rollout", field).agreement().agrees
    other = BenchmarkRobots(race)
    other.__dict__["recorded"] = np.zeros_like(field.recorded)
    assert not CRunner("rollout", other).agreement().agrees


def test_a_process_of_its_own_tells_time_and_memory(race) -> None:
    found = alone("serial", race)
    assert found["compile_s"] == 0.0 and found["first_result_s"] > 0.0
    assert 10.0 < found["peak_mb"] < 20_000.0 and 0.0 <= found["rise_mb"] <= found["peak_mb"]
    assert peak_mb() > 10.0


@pytest.mark.slow
def test_a_second_process_finds_the_programs_of_the_first(race) -> None:
    found = alone("lanes", race)
    assert 0.0 < found["first_result_s"] < found["compile_s"]


def test_a_sweep_goes_through_the_populations(race, progress) -> None:
    made = lambda name, field: Fake(name) if name == "lanes" else runner(name, field)  # noqa: E731
    points = sweep(race, ("serial", "batch", "lanes"), progress, made, largest=8)
    assert [(p["engine"], p["robots"]) for p in points] == [
        *(("batch", n) for n in (1, 8)),
        *(("lanes", n) for n in (1, 2, 4, 8)),
    ]
    assert [p["share_of_neighbours"] is None for p in points] == [True, True, True, False, False, True]


def test_feet_alone_touch() -> None:
    robot, nominal = load(None, feet=True), load(None, feet=False)
    touching = [n for n, a in zip(robot.names("geom"), robot.model.geom_conaffinity, strict=True) if a and n != "floor"]
    assert sorted(n for n in touching if n.startswith("foot")) == ["foot_b", "foot_f", "foot_l", "foot_r"]
    assert not [n for n in touching if n.startswith(("knee", "corner"))]
    assert nominal.model.geom_conaffinity.sum() > robot.model.geom_conaffinity.sum()


def test_what_it_refuses(race, tmp_path) -> None:
    with pytest.raises(InputError, match="--population"):
        BenchConfig(population=0)
    with pytest.raises(InputError, match="--substeps"):
        BenchConfig(substeps=(4, 0))
    with pytest.raises(InputError, match="--feet"):
        BenchConfig(race.model, feet=True).races()
    arm = Path(tmp_path / "arm.xml")
    arm.write_text(PENDULUM)
    with pytest.raises(InputError, match="cannot travel"):
        BenchmarkRobots(replace(race, model=str(arm)))


def test_the_shipped_steps_and_one_are_the_races() -> None:
    assert [r.substeps for r in BenchConfig().races()] == [4, 1]
    assert [r.substeps for r in BenchConfig(substeps=(2, 2)).races()] == [2]
