"""The table of counts: every study of robustness stands in it, with the counts of its summary."""

import json

from experiments.robustness.trust.run import HERE, STUDIES, table


def test_every_study_of_robustness_is_in_it():
    assert {path.parent.name for path in HERE.parent.glob("*/run.py")} == {*STUDIES, "trust"}


def test_published_counts_are_read():
    text, failed = table(HERE.parent)
    fuzz = json.loads((HERE.parent / "fuzz" / "summary.json").read_text(encoding="utf-8"))
    assert f"| bad input: csv | {fuzz['csv']['tried']} | {fuzz['csv']['crashes']} |" in text and failed >= 0


def test_what_was_not_as_promised_is_counted(tmp_path):
    (tmp_path / "wrong_logs").mkdir()
    found = {"wrong": 10, "named": 8, "right": 10, "warned": 1, "check_s": {"largest": 2.0}}
    (tmp_path / "wrong_logs" / "summary.json").write_text(json.dumps(found))
    text, failed = table(tmp_path)
    assert failed == 3 and "| right logs: warned of | 10 | 1 |" in text and "| fuzz | not yet |" in text
