"""The study of what a diagnosis is worth."""

from experiments.recover.oracle_diagnosis.summary import summary


def test_ratios_are_given_by_situation() -> None:
    def pair(situation: int, before: float, damaged: float, own: float, oracle: float) -> tuple[dict, dict]:
        line = {"robot": "same", "situation": situation, "before": before, "damaged": damaged, "right_4": True}
        return {**line, "trial_4": own}, {**line, "trial_4": oracle}

    found = summary([pair(1, 2.0, 0.5, 1.0, 2.0), pair(1, 2.0, 0.9, 1.5, 1.5), pair(2, 2.0, 1.5, 1.0, 0.0)])["same"]
    assert found["situations"]["1"]["ratio"] == 0.75 and found["severe"] == {"n": 2, "twice": 1}
    assert found["situations"]["2"]["ratio"] is None, "a run that came nowhere though it knew is no measure"
