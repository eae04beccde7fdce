"""The advice and the page agree."""

from estexp_jax.report.propose.advice import propose_advice
from estexp_jax.report.propose.page import propose_page
from tests.report.examples import proposal


def test_page_and_advice_say_the_same():
    text, html = propose_advice(proposal()), propose_page(proposal())
    for told in ("1.99", "0.0054", "beyond a limit", "holds 1.99 s of commands"):
        assert (told in text) == (told in html)
