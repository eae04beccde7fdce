"""`check` tells faults of logging as the nominal model sees them, each with its remedy."""

import pytest

from estexp_jax.recordings.checks.inspect import judge
from estexp_jax.recordings.checks.model_faults import assumed, model_faults
from tests.estimation.two_links import arm, faulty, log_of


def test_a_right_log_has_none():
    assert [*model_faults(arm(), log_of(arm()))] == [] == assumed(arm(), log_of(arm()))


@pytest.mark.parametrize(
    ("fault", "name", "told"),
    [
        ("channels_exchanged@q_shoulder with=q_elbow", "sensor.q_shoulder", "q_elbow in each other's place"),
        ("command_lead lead=0.025", "time", "before their rows"),
        ("command_lead lead=-0.025", "time", "after their rows"),
        ("no_signal@q_elbow copy_of=m_elbow", "sensor.q_elbow", "a copy of channel m_elbow"),
    ],
)
def test_each_names_what_is_wrong_and_what_to_do(fault, name, told):
    judged = judge(arm(), faulty(arm(), log_of(arm()), fault))
    kind = fault.partition("@")[0].partition(" ")[0]
    [found] = [f for f in judged["faults"] if f["kind"] == kind]
    assert found["name"] == name and told in found["sentence"] and "; " in found["sentence"]


def test_nothing_is_replayed_where_it_is_not_wanted():
    wrong = faulty(arm(), log_of(arm()), "channels_exchanged@q_shoulder with=q_elbow")
    assert "channels_exchanged" not in {f["kind"] for f in judge(arm(), wrong, replayed=False)["faults"]}
