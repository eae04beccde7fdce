"""The planted set holds what it says, and its scores count what they say."""

import json
import sys
from collections import Counter
from dataclasses import replace

import pytest

from estexp_jax.errors import InputError
from experiments.benchmark.generator.catalogue import SINGLE, places
from experiments.benchmark.generator.making import make
from experiments.benchmark.scoring.judge import Row, Size
from experiments.explain.planted import run as front
from experiments.explain.planted.plans import PARTS, planned
from experiments.explain.planted.scores import measured, write_scores
from experiments.explain.planted.study import planted
from experiments.harness import explain_runner
from experiments.harness.explain_study import row_of


def test_every_effect_is_planted_five_times_wherever_it_fits() -> None:
    found = Counter((p.planted[0].effect, p.robot) for p in planned(3, "single"))
    wanted = {(name, robot) for robot in ("leg", "planar") for name in SINGLE if places(name, robot)}
    assert set(found) == wanted and set(found.values()) == {5}
    assert Counter(p.group for p in planned(3, "nothing")) == {"null": 50, "parameters": 50}


def test_parts_make_the_whole_and_only_the_seed_decides() -> None:
    whole = planned(4)
    parts = [p for part in PARTS[1:] for p in planned(4, part)]
    assert len({p.seed for p in whole}) == len(whole)
    assert sorted(p.seed for p in whole) == sorted(p.seed for p in parts)
    assert planned(4) == whole and planned(5) != whole


def test_plain_cases_have_ordinary_errors_of_one_percent_and_fine_encoders() -> None:
    [plan, *_] = planned(6, "nothing")
    case = make(plan, shorter=0.1, refit=False)
    assert case.deviation == 0.01
    assert (case.instruments.bits, case.instruments.memory, case.instruments.dropped) == (14, 0.0, 0.0)


def _row(group: str, **what) -> Row:
    return Row(**{"case": "c", "group": group, "robot": "leg", "truth": "x", "shown": 9.0, "visible": True} | what)


def test_scores_count_what_they_say() -> None:
    size = Size("x", "c", 1.0, 1.04, 0.04, True)
    rows = [
        _row("single", verdict="missing_physics", place_first=True, name_equivalent=True, gain=0.9, sizes=(size,)),
        _row("single", verdict="unexplained", place_first=True, name_equivalent=False, gain=0.1),
        _row("single", verdict="none", visible=False, shown=1.0),
        _row("null", verdict="unexplained", alarm=True, visible=False),
        _row("parameters", verdict="parameters", visible=False),
        _row("single", verdict="missing_physics", robot="quadruped", place_first=False, name_equivalent=False),
    ]
    table = {what: found for what, _, found in measured(rows)}
    assert table["effects too weak to be seen"] == "1 of 3"
    assert table["right place first"].startswith("2 of 2 ")
    assert table["right name first, or one that says the same"].startswith("1 of 2 ")
    assert table["error of parameters, median and 90 %"].startswith("4.0 %, 4 %")
    assert table["held-out excess error removed, median"].startswith("50 %")
    assert table["alarms where nothing is missing"].startswith("1 of 2 ")
    assert table["quadruped: right place first"].startswith("0 of 1 ")


def test_a_folder_with_results_is_not_written_over(tmp_path) -> None:
    (tmp_path / "mine").touch()
    with pytest.raises(InputError, match="--resume"):
        front.main(["--out", str(tmp_path)])


def test_a_part_keeps_the_ids_of_the_whole() -> None:
    study = planted(front.__file__, None)
    whole, two = study.planned(9, "all"), study.planned(9, "two")
    assert len(two) == 20 and all(whole[case] == plan for case, plan in two.items())


ANSWER = {
    "effects": [],
    "group": "null",
    "robot": "leg",
    "visibility": {"shown": 0.0},
    "equivalents": [],
}
EXPLAIN = """
import json, pathlib, sys
manifest, out = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[3])
assert manifest.parent.is_dir()
out.mkdir()
(out / "findings.json").write_text(json.dumps(FINDINGS))
sys.exit(2 if manifest.parent.name == "c001" else 0)
"""
FINDINGS = {
    "verdict": "parameters",
    "what": [],
    "where": [],
    "fit": {
        **{name: {"train": 0.1, "test": 0.1} for name in ("nominal", "parameters_only", "explained", "noise_floor")},
        "placebo": {},
        "gain": {"value": 0.5},
    },
    "cost": {"robot_steps": 7},
}


def test_a_case_becomes_a_row_and_what_is_published_is_not_done_again(tmp_path, monkeypatch) -> None:
    command = (sys.executable, "-c", EXPLAIN.replace("FINDINGS", repr(FINDINGS)))
    monkeypatch.setattr(explain_runner, "_die_with_worker", None)  # it forks, of which JAX, where it is loaded, warns
    some = replace(
        planted(front.__file__, None), seed=4, published=tmp_path / "rows.parquet", command=lambda _: command
    )
    plan = planned(4, "nothing")[0]
    for case in ("c000", "c001"):
        (tmp_path / "cases" / case).mkdir(parents=True)
        (tmp_path / "cases" / case / "recordings.toml").touch()  # drawn already
        (tmp_path / "drawn").mkdir(exist_ok=True)
        (tmp_path / "drawn" / f"{case}.json").write_text(json.dumps(ANSWER))
        some.explained(tmp_path, case, plan, 60.0)
    assert [p.name for p in (tmp_path / "cases").iterdir()] == ["c001"]  # a failure can be looked at
    entries = some.entries(tmp_path, 4)
    rows = [row_of(entry) for entry in entries.values()]
    assert [r.verdict for r in rows] == ["parameters", "none"] and rows[0].robot_steps == 7
    assert some.main(["run", "--most", "0", "--publish", "--resume", "--out", str(tmp_path)]) == 0
    with pytest.raises(SystemExit):
        some.main(["score", "--publish", "--seed", "5", "--out", str(tmp_path)])
    elsewhere = some.entries(tmp_path / "elsewhere", 4)
    assert elsewhere == entries and some.entries(tmp_path / "elsewhere", 5) == {}
    page = write_scores(tmp_path, list(entries.values()), 490).read_text()
    assert page.startswith("2 of 490 cases") and "0 of 2" in page
