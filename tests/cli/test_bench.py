"""estexp bench: measures, prints a table, writes numbers and figures."""

import json

import pytest

from estexp_jax.cli.main import main
from tests.physics.robots import CARTPOLE

ENGINE = ("name", "robot_steps_per_s", "ratio_to_serial", "compile_s", "first_result_s", "peak_mb")


@pytest.fixture
def cartpole(tmp_path, monkeypatch):
    (tmp_path / "cartpole.xml").write_text(CARTPOLE)
    monkeypatch.chdir(tmp_path)
    measured = {"compile_s": 1.0, "first_result_s": 0.1, "peak_mb": 9.0}
    monkeypatch.setattr("estexp_jax.benchmark.measure.JAX_ENGINES", ("lanes",))  # MJX compiles for long
    monkeypatch.setattr(
        "estexp_jax.benchmark.measure.alone",
        lambda name, race: measured,
    )
    return tmp_path


def test_it_writes_what_the_specification_names(cartpole, capsys) -> None:
    small = ["--population", "4", "--steps", "5", "--repeats", "1", "--substeps", "2"]
    command = ["bench", "--model", "cartpole.xml", "--out", "out", *small]
    assert main(command) == 0
    told = capsys.readouterr().out
    assert "x serial" in told and "serial_open" in told and "An estimation generation" in told and "bench.json" in told
    result = json.loads((cartpole / "out" / "bench.json").read_text())
    assert result["model"] == "cartpole.xml" and result["population"] == 4 and result["steps"] == 5
    assert [e["name"] for e in result["engines"]][0] == "serial" and result["engines"][-1]["name"] == "lanes"
    for entry in result["engines"]:
        assert all(entry[key] is not None for key in ENGINE)
    assert result["estimation"]["robot_steps"] == 4 * 4 * 21 * 2
    assert (cartpole / "out" / "bench.png").stat().st_size > 10_000
    assert "<svg" in (cartpole / "out" / "bench.svg").read_text()[:500]
    assert main(command) == 2 and "--force" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--population", "0"], "--population"),
        (["--substeps", "0"], "--substeps"),
        (["--model", "cartpole.xml", "--feet"], "--feet"),
        (["--model", "no.xml"], "no.xml"),
    ],
)
def test_wrong_input_is_two(cartpole, capsys, arguments, told) -> None:
    assert main(["bench", "--out", "out", *arguments]) == 2
    assert told in capsys.readouterr().err
    assert not (cartpole / "out").exists()
