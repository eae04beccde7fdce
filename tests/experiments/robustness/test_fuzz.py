"""Bad input of every kind: some here, drawn by hypothesis and by seeds; all of it in the study."""

import json
import random
from collections import Counter

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from experiments.robustness.fuzz import draw, folders, logs, models, trial
from experiments.robustness.fuzz.run import Tally, _note
from tests.conftest import ROOT

WITHOUT_RUNS = [kind for kind in trial.KINDS if kind != "run_folder"]
SOME, MANY = 12, 150
SLOW = [HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much, HealthCheck.large_base_example]


@pytest.mark.parametrize("kind", WITHOUT_RUNS)
def test_bad_input_is_refused_with_one_message(kind, tmp_path):
    if kind == "mcap":
        pytest.importorskip("mcap", reason="MCAP needs the extra `mcap`: pip install 'estexp_jax[mcap]'")
    make, found = trial.makers(tmp_path)[kind], []
    settled = settings(max_examples=SOME, database=None, suppress_health_check=SLOW, derandomize=True)

    @settled
    @given(st.randoms(use_true_random=False))
    def tried(source):
        found.append(trial.attempt(make, source))
        assert found[-1].result in ("refused", "accepted"), found[-1].message

    tried()
    for number in range(SOME):
        found.append(trial.attempt(make, random.Random(f"{kind} {number}")))
        assert found[-1].result in ("refused", "accepted"), found[-1].message
    assert len({outcome.digest for outcome in found}) > SOME
    assert Counter(outcome.result for outcome in found)["refused"] > SOME / 2


@pytest.mark.parametrize("place", range(len(models.HUGE)))
def test_models_without_end_cost_neither_time_nor_memory(place, tmp_path):
    def make(_, folder):
        (folder / "model.xml").write_bytes(models._added(models.HUGE[place]))
        (folder / "log.csv").write_bytes(logs.good_csv())
        return ["check", str(folder / "model.xml"), str(folder / "log.csv"), *logs.MAP]

    before = trial.peak_mb()
    outcome = trial.attempt(make, random.Random(0))
    assert outcome.result in ("refused", "accepted"), outcome.message
    assert trial.peak_mb() - before < 300.0


@pytest.mark.slow
def test_damaged_results_are_refused_with_one_message(tmp_path):
    from experiments.robustness.fuzz.run import good_results

    good_results(tmp_path)
    make = folders.RunFolders(tmp_path)
    trial.warm(make)
    found = [trial.attempt(make, random.Random(f"run_folder {k}")) for k in range(MANY)]
    assert [outcome.message for outcome in found if outcome.result == "defect"] == []
    assert sum(outcome.result == "refused" for outcome in found) > MANY / 2


def test_the_judge_tells_what_is_no_single_message():
    assert trial.judged(2, "estexp: error: a.csv: no\n")[0] == "refused"
    assert trial.judged(0, "")[0] == "accepted"
    for code, message in ((1, "estexp: error: x"), (2, "Traceback\nestexp: error: x"), (2, ""), (3, "")):
        assert trial.judged(code, message)[0] == "defect"


def test_a_defect_a_hang_and_a_change_outside_are_seen(monkeypatch):
    def raising(_, folder):
        raise AssertionError  # making an input must not fail silently

    with pytest.raises(AssertionError):
        trial.attempt(raising, random.Random(0))
    monkeypatch.setattr(trial, "_command", lambda argv: 1 // 0)
    assert "ZeroDivisionError" in trial.attempt(logs.csv, random.Random(0)).message
    monkeypatch.setattr(trial, "LONGEST_S", 0.2)
    monkeypatch.setattr(trial, "_command", lambda argv: [None for _ in iter(int, 1)])
    assert "hang" in trial.attempt(logs.csv, random.Random(0)).message
    monkeypatch.setattr(trial, "_command", lambda argv: (open("../canary", "w").close(), 0)[1])
    assert trial.attempt(logs.csv, random.Random(0)).message == "a file outside was changed"


def test_bytes_decide_and_run_out():
    one, two = draw.Bytes(b"\x01\x02\x03\x04" * 4), draw.Bytes(b"\x01\x02\x03\x04" * 4)
    assert [one.random() for _ in range(4)] == [two.random() for _ in range(4)] != [0.0] * 4
    assert one.random() == 0.0 and one.randrange(7) == 0 and one.choice("abc") == "a"


def test_the_tally_counts_distinct_inputs():
    tally, seen = Tally(), {"seconds": 0.1, "peak_mb": 5.0, "message": ""}
    for index, (digest, result) in enumerate([("a", "refused"), ("a", "refused"), ("b", "accepted"), ("c", "defect")]):
        _note(tally, {"index": index, "digest": digest, "result": result, **seen})
    row = tally.row()
    assert (row["tried"], row["refused"], row["accepted"], row["crashes"]) == (3, 1, 1, 1)


def test_the_published_table_is_that_of_the_results():
    folder = ROOT / "experiments" / "robustness" / "fuzz"
    message, text = json.loads((folder / "summary.json").read_text()), (folder / "README.md").read_text()
    assert set(message) == set(trial.KINDS)
    for kind, row in message.items():
        assert f"| {kind} | {row['tried']} | {row['refused']} | {row['accepted']} | {row['crashes']} |" in text
