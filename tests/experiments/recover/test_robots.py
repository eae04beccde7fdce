"""Recovery on other robots, at the smallest size."""

import json
from pathlib import Path

import pytest

from estexp_jax.physics.effects.changes import parse_change
from experiments.harness.rows import read_rows
from experiments.recover.robots.cases import DAMAGES, RobotCase, job, outcome
from experiments.recover.robots.figure import distances_figure
from experiments.recover.robots.run import main


def test_damages_have_their_places() -> None:
    from estexp_jax.package_data import model_path
    from estexp_jax.physics.model.robot import Robot

    for model, damages in DAMAGES.items():
        robot = Robot.from_xml(model_path(model))
        assert all(parse_change(damage, robot).kind for damage in damages)
    names = {RobotCase(m, d, seed, "small").name for m, ds in DAMAGES.items() for d in ds for seed in (0, 1)}
    assert len(names) == 8


@pytest.mark.slow
def test_a_lost_leg_of_the_hexapod_is_found(tmp_path: Path) -> None:
    case = RobotCase("hexapod", "part_lost@leg_rm", 7, "quick")
    row = outcome(case, tmp_path)
    assert row["right"] and row["right_after"] == 1
    assert outcome(case, tmp_path) == row  # kept, not run again
    assert job(case).simulator.closed_loop.choice.engine == "lanes"
    assert len(distances_figure([row]).axes) == 1


@pytest.mark.slow
def test_the_experiment_runs(tmp_path: Path) -> None:
    assert main(["--quick", "--out", str(tmp_path)]) == 0
    found = json.loads((tmp_path / "quick" / "robots" / "summary.json").read_text())
    assert found["of"] == 4 and len(read_rows(tmp_path / "quick" / "robots" / "rows.parquet")) == 4
