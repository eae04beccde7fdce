"""The bench's figure shows what was timed, and only that."""

import pytest

from estexp_jax.report.bench.figures import bench_figure


def _race(substeps: int, **ratios: float | None) -> dict:
    rates = {name: None if x is None else 5e4 * x for name, x in ratios.items()}
    entries = [{"name": n, "ratio_to_serial": x, "robot_steps_per_s": rates[n]} for n, x in ratios.items()]
    return {"substeps": substeps, "engines": entries}


@pytest.fixture
def result() -> dict:
    sweep = [{"engine": "lanes", "robots": n, "robot_steps_per_s": 1e4 * n} for n in (1, 10, 100)]
    about = {"model": "quadruped", "population": 200, "cores": 2, "versions": {"cpu": "a processor"}}
    return {**about, **_race(4, serial=1.0, mjx=None, lanes=20.4), "also": [_race(1, serial=1.0)], "sweep": sweep}


def test_a_panel_for_each_race_and_the_sweep(result) -> None:
    first, second, swept = bench_figure(result).axes  # MJX was refused, so it has no bar
    assert [t.get_text() for t in first.get_yticklabels()] == [
        "C, one at a time",
        "lanes",
    ]
    assert [t.get_text() for t in first.texts] == [" 1.0x, 50 k/s", " 20x, 1.02 M/s"]
    assert first.get_title() == "4 physics steps a control step" and second.get_title().startswith("1 physics step ")
    lanes, serial = swept.get_lines()
    assert list(lanes.get_xdata()) == [1, 10, 100] and serial.get_ydata()[0] == 5e4


def test_without_a_sweep_there_are_bars_alone(result) -> None:
    figure = bench_figure({**result, "sweep": [], "also": []})
    assert len(figure.axes) == 1


def test_it_can_be_written(result, tmp_path) -> None:
    for ending in ("png", "svg"):
        bench_figure(result).savefig(tmp_path / f"bench.{ending}")
        assert (tmp_path / f"bench.{ending}").stat().st_size > 5000
