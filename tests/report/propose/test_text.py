"""A proposal as text: pairs, verdict, and the readings that distinguish explanations."""

import pytest

from estexp_jax.report.propose.text import (
    column_of,
    distinguishing_readings,
    propose_rows,
    propose_summary,
    propose_table,
    propose_verdict,
    rival_status,
)
from tests.report.examples import proposal


def test_each_pair_has_its_separation_and_its_largest_difference():
    rows = propose_rows(proposal())
    assert [(row["rival"], row["other"], row["separation"], row["told_apart"]) for row in rows] == [
        (1, 2, 9.0, True), (1, 3, 0.2, False), (2, 3, 12.0, True),
    ]  # fmt: skip
    assert rows[0]["unit"] == "rad" and rows[0]["time"] == pytest.approx(1.99)


@pytest.mark.parametrize(
    ("separations", "verdict"),
    [
        ((9.0, 9.0, 9.0), "any two differ by 9 deviations or more."),
        ((9.0, 0.2, 12.0), "no motion found does so plainly for 1 and 3. Wider limits"),
        ((9.0, 1.2, 12.0), "Still record it"),
        ((1.0, 0.1, 0.2), "none brings two of them 3 deviations apart"),
    ],
)
def test_the_verdict_counts_the_distinguished_pairs(separations, verdict):
    assert verdict in propose_verdict(proposal(separations))


def test_each_explanation_has_a_reading_that_distinguishes_it():
    first, second, third = distinguishing_readings(proposal())
    assert (first["number"], second["number"], third["number"]) == ("1", "2", "3")
    assert second["time"] == "1.99" and second["own"] == "-0.129 rad" and second["others"] == "-0.308 to -0.306 rad"


def test_summary_and_table_list_all_explanations():
    p = proposal()
    summary, table = propose_summary(p), propose_table(p)
    assert "1 is possible" in summary and "3. sensor_bias@" in summary and table.count("<li>") == 3
    assert "<i>" not in table
    assert [rival_status(rival) for rival in p.competing_models.models] == [
        "probability 60 %",
        "probability 40 %",
        "refuted already",
    ]


def test_sensors_and_joints_have_their_columns():
    p = proposal()
    assert column_of(p.robot, p.competing_models.channels[0]) == f"sensor.{p.competing_models.channels[0]}"
    assert column_of(p.robot, "qpos.knee") == "qpos.knee"
