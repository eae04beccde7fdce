"""Findings as text and as HTML."""

from copy import deepcopy

from estexp_jax.report.explain.text import claim, explain_rows, explain_summary, explain_table, intervals, proof
from tests.report.examples import FINDINGS, LONG


def test_a_claim_has_its_numbers_and_its_probability():
    text = claim(FINDINGS["what"][0])
    assert text == "The joint resists motion with 1.02 N m (T = 1.02 (0.97 to 1.08) N m; probability 94%)."
    unbounded = deepcopy(FINDINGS["what"][0])
    unbounded["parameters"]["T"]["high"] = None
    assert intervals(unbounded) == "T = 1.02 (at least 0.97) N m"
    unbounded["parameters"]["T"]["low"] = None
    assert intervals(unbounded) == "T = 1.02 N m"


def test_the_summary_names_verdict_claims_proof_and_likely_alternatives():
    lines = explain_summary(FINDINGS).split("\n")
    assert lines[0] == "The simulator lacks physics." and len(lines) == 5
    assert "93% of the excess is gone (90 % interval 90% to 95%)" in lines[3]
    assert lines[4] == "It could also be parameters alone (5%)."


def test_with_healthy_recordings_it_is_told_what_changed():
    healthy = [{**entry, "role": "healthy"} for entry in FINDINGS["data"]]
    findings = {**FINDINGS, "data": [*healthy, *FINDINGS["data"]], "baseline": FINDINGS["what"][:1]}
    text = explain_summary(findings)
    assert text.startswith("The robot has changed since it was healthy.")
    assert "When it was healthy: The joint resists motion with 1.02 N m" in text
    assert explain_summary({**findings, "verdict": "consistent", "what": []}).startswith("Nothing has changed since")


def test_without_a_gain_the_proof_is_the_errors():
    findings = {**FINDINGS, "fit": {**FINDINGS["fit"], "gain": {"value": None, "low": None, "high": None}}}
    assert proof(findings) == (
        "On recordings not used for fitting the error is 0.04 instead of 0.04 of the sensors' range."
    )


def test_the_table_has_a_row_for_each_parameter():
    assert [(row["at"], row["parameter"]) for row in explain_rows(FINDINGS)] == [(LONG, "T"), (LONG, "T")]
    html = explain_table(FINDINGS)
    assert html.count("<tr>") == 3 and "<td>1.02</td>" in html
    assert "<table>" not in explain_table({**FINDINGS, "what": []})
