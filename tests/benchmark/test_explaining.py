"""Whole commands are timed in processes of their own, in turns with mujoco.sysid; nothing here asserts a speed."""

import json
from collections.abc import Sequence
from pathlib import Path

import pytest

from estexp_jax.benchmark import explaining
from estexp_jax.benchmark.explaining import ShippedLog, explaining_times
from estexp_jax.report.bench.text import bench_sentences, explaining_table

_LOG = ShippedLog("leg", "coulomb_friction@knee T=0.6", 4.0)
_FINDINGS = {
    "cost": {"robot_steps": 7},
    "verdict": "missing_physics",
    "what": [{"effect": "coulomb_friction", "name": "knee"}],
}


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Which processes are started; explaining takes 9, 4, 6 and 5 s, fitting 2, 3 and 1 s."""
    order, walls = list[str](), {"explain": iter([9.0, 4.0, 6.0, 5.0]), "sysid": iter([2.0, 3.0, 1.0])}

    def run(arguments: Sequence[str], folder: Path) -> tuple[float, float]:
        kind = arguments[2] if arguments[0] == "-c" else "sysid"
        order.append(kind)
        if kind == "explain":
            out = Path(arguments[arguments.index("--out") + 1])
            out.mkdir(exist_ok=True)
            (out / "findings.json").write_text(json.dumps(_FINDINGS))
        return (next(walls[kind]) if kind in walls else 1.0), 100.0

    monkeypatch.setattr(explaining, "_run", run)
    return order


def test_medians_of_turns_beside_sysid(asked: list[str], progress, monkeypatch) -> None:
    monkeypatch.setattr(explaining, "sysid_version", lambda: "4.0.0")
    (entry,) = explaining_times(3, 0, progress, [_LOG])
    assert asked == ["record", "explain", *["explain", "sysid"] * 3]
    assert (entry["cold_s"], entry["wall_s"], entry["sysid"]["wall_s"], entry["ratio_to_sysid"]) == (9.0, 5.0, 2.0, 2.5)
    assert entry["found"] == ["coulomb_friction@knee"] and entry["robot_steps"] == 7
    table = explaining_table({"explain": [entry]})
    assert table is not None
    assert table.rows == [(_LOG.effect, "coulomb_friction@knee", "9", "5", "100", "2", "100", "2.5")]


def test_without_sysid_there_is_no_ratio_and_it_is_said(asked: list[str], progress, monkeypatch) -> None:
    monkeypatch.setattr(explaining, "sysid_version", lambda: None)
    (entry,) = explaining_times(1, 0, progress, [_LOG])
    assert "sysid" not in asked
    assert entry["sysid"] is None and entry["ratio_to_sysid"] is None
    told = list(bench_sentences({"engines": [], "notes": [], "explain": [entry]}))
    assert told == ["mujoco.sysid is not installed: pip install 'mujoco[sysid]'"]


def test_a_command_is_measured_in_a_process_of_its_own(tmp_path: Path) -> None:
    wall, memory = explaining._run(["-c", explaining._COMMAND, "--version"], tmp_path)
    assert 0.0 < wall < 60.0 and 10.0 < memory < 4000.0
    with pytest.raises(RuntimeError, match="ended with 2"):
        explaining._run(["-c", explaining._COMMAND, "explain", str(tmp_path / "none.xml"), "--out", "x"], tmp_path)


@pytest.mark.slow
def test_what_is_shipped_is_recorded_and_explained(progress) -> None:
    for entry in explaining_times(1, 3, progress):
        assert entry["found"] == [entry["effect"].split()[0]]
        assert entry["cold_s"] > 0.0 and entry["peak_mb"] > 100.0
