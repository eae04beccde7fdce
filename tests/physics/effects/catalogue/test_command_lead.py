"""Commands that act before their rows cannot be physics; those that act after them can."""

from dataclasses import replace

from estexp_jax.physics.effects.catalogue.command_lead import CommandLead
from tests.estimation.two_links import arm, log_of


def test_only_a_lead_is_undone():
    e = CommandLead()
    assert e.is_undone({"lead": 0.02}) and not e.is_undone({"lead": -0.02})
    assert "20 ms before" in e.sentence("", {"lead": 0.02}) and "20 ms after" in e.sentence("", {"lead": -0.02})


def test_less_than_half_a_row_is_not_tried():
    slow = log_of(arm())
    tried = CommandLead().tried(arm(), "", replace(slow, time=20.0 * slow.time))
    assert min(abs(lead) for (lead,) in tried) >= 0.04
