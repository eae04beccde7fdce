"""The study of which trial to make next."""

from pathlib import Path

import pytest

from experiments.recover.next_trial import summary as next_trial
from experiments.recover.next_trial.run import published, tasks_of


def rows(way: str, seed: int, right: list[bool]) -> list[dict]:
    about = {"part": "diagnosis", "next_trial": way, "situation": 3, "seed": seed}
    return [{**about, "trials": i, "right": each} for i, each in enumerate(right, start=1)]


def test_a_diagnosis_counts_from_where_it_stays_right() -> None:
    tried = [*rows("drawn", 1, [True, False, True]), *rows("drawn", 2, [False] * 3), *rows("drawn", 3, [True] * 3)]
    assert next_trial.trials_needed(tried) == {(3, 1): 3, (3, 2): 4, (3, 3): 1}


def test_ways_to_choose_are_compared_pair_by_pair(tmp_path: Path) -> None:
    tried = [r for i in range(8) for r in rows("drawn", i, [False, False, True])]
    tried += [r for i in range(6) for r in rows("informative", i, [False, True, True])]
    found = next_trial.summary(tried)["diagnosis"]
    assert found["paired"] == {"pairs": 6, "fewer": 6, "more": 0, "p": pytest.approx(2.0**-6)}
    assert found["drawn"]["right_after"]["3"]["share"] == 1.0 and found["informative"]["right_after"]["2"]["n"] == 6
    next_trial.draw(tried, tmp_path)
    assert (tmp_path / "next_trial.png").stat().st_size > 0


def test_published_diagnoses_are_not_made_again() -> None:
    ways = {"informative" if task.informative else "drawn" for task in tasks_of((1,), 1)}
    assert ways == {way for way, _, _ in published()}
