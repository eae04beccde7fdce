"""The page of a run from a made-up state: verdict, headline, advice."""

from dataclasses import replace

import numpy as np
import pytest

from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.state import RunState
from estexp_jax.report.recover.page import recover_advice, recover_headline, recover_page, recover_verdict
from estexp_jax.report.recover.run_data import run_record
from estexp_jax.runs.files import json_plain
from tests.report.examples import LOST, WEAK, recovered, trial


@pytest.fixture
def state() -> RunState:
    return recovered()


def test_page_stands_alone_and_reports_the_damage(state: RunState) -> None:
    html = recover_page("<run>", [WEAK], state, "x", {"seed": 0})
    assert "http" not in html.replace("http-equiv", "")
    assert "&lt;run&gt;" in html
    assert html.count("data:image/svg+xml;base64") == 2
    assert "The true damage: the motor knee_f lost 48 % of its strength" in html
    assert "2.00 m before" in recover_headline(state, "x") and "1.70 m, 85 % of before" in recover_headline(state, "x")
    assert recover_headline(state, "x").endswith("Found after 1 trial: the motor knee_f lost 48 % of its strength.")


def test_the_verdict_is_what_the_last_trial_won_back(state: RunState) -> None:
    for distance, told in ((1.9, "walks again."), (1.3, "in part"), (0.5, "has not recovered")):
        assert told in recover_verdict(replace(state, trials=(trial(0.4), trial(distance))), "x")
    assert "cost the robot nothing" in recover_verdict(replace(state, before=trial(0.3)), "x")
    assert recover_verdict(replace(state, trials=(trial(0.4),)), "x") == "The robot is damaged."
    assert "not been damaged" in recover_verdict(RunState(), "x")


def test_advice_follows_from_alarm_alternatives_and_predictions(state: RunState) -> None:
    assert recover_advice(state, "x") == []
    doubtful = replace(state, alarms=(True,), alternatives=((((LOST,), 0.2),),), simulated=(2.0, 0.6))
    told = " ".join(recover_advice(doubtful, "x"))
    assert "--model-error" in told and "55 %" in told and "--passes" in told
    html = recover_page("run", [LOST], doubtful, "x", {})
    assert "do not trust" in html and "20 %" in html and "upper_&lt;b&gt;f" in html and "<b>f" not in html
    lame = replace(state, trials=(trial(0.4), trial(0.5)), simulated=(2.0, 0.5))
    assert "--generations" in " ".join(recover_advice(lame, "x"))


def test_page_of_a_run_without_passes(state: RunState) -> None:
    young = RunState(before=trial(1.0), trials=(trial(0.2),), history=state.history[:3])
    assert "nothing was planted" in recover_page("run", [], young, "x", {})


def test_a_robot_of_the_users_may_come_an_unknown_way(state: RunState) -> None:
    unseen = replace(trial(0.0), position=np.full((30, 3), np.nan))
    measured, state = state, replace(state, trials=(unseen, unseen))
    assert recover_verdict(state, "x") == "How far the robot walks is not known."
    told = recover_headline(state, "x", stands_in=True)
    assert told.startswith("The undamaged simulator walked 2.00 m, the damaged robot an unknown distance;")
    html = recover_page("run", None, state, "x", {}, stands_in=True)
    assert "true damage" not in html and "the undamaged simulator" in html and "nan m" not in html
    assert "seen from above" not in html and "seen from above" in recover_page("run", None, measured, "x", {})
    assert recover_advice(state, "x") == []
    written = json_plain(run_record(state, "x", [], Settings().to_json(), stands_in=True))
    assert written["distance"] == {"before": None, "damaged": None} and written["passes"][0]["hardware_m"] is None
