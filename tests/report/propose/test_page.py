"""The report of a proposed motion: what is open, where it shows, what to do; nothing from elsewhere."""

import pytest

from estexp_jax.report.propose.page import propose_headline, propose_page
from tests.report.examples import LONG, proposal


def test_it_tells_rivals_moments_and_what_to_do():
    html = propose_page(proposal())
    assert html.count('src="data:image/svg+xml;base64,') == 2
    for told in (
        "it tells 2 of 3 pairs of explanations apart", "resists motion with 0.3 N m", "tau = -T sign(w)",
        f"coulomb_friction@{LONG}", "Probability 60 %", "Refuted already", "Careful:", "5% beyond a limit",
        "1, 2", "1.99", "0.18 rad", "estexp explain MODEL.xml a.csv proposed.csv --test b.csv", "0.12 million",
    ):  # fmt: skip
        assert told in html, told
    assert html.count("claim pale") == 1
    assert "arms &lt;1&gt;.xml" in html and "<i>" not in html


@pytest.mark.parametrize(
    ("apart", "told"),
    [((9.0, 9.0, 9.0), "it tells the explanations apart"), ((1.0, 0.1, 0.2), "No motion found within the limits")],
)
def test_the_headline_claims_no_more_than_there_is(apart, told):
    assert told in propose_headline(proposal(apart)) and told in propose_page(proposal(apart))
