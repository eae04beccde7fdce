"""Only channels alike can stand in each other's place; whole joints do, with their readings and commands."""

from estexp_jax.physics.effects.catalogue.channels_exchanged import ChannelsExchanged
from tests.estimation.two_links import arm, log_of


def test_readings_go_with_readings_and_commands_with_commands():
    e, robot = ChannelsExchanged(), arm()
    assert e.sites(robot) == ("q_shoulder", "q_elbow", "m_shoulder", "m_elbow")
    tried = {site: e.tried(robot, site, log_of(robot)) for site in e.sites(robot)}
    assert tried == {"q_shoulder": [(2.0,)], "q_elbow": [], "m_shoulder": [(4.0,)], "m_elbow": []}


def test_whole_joints_are_tried_too():
    [both] = ChannelsExchanged().tried_together(arm())
    assert [tuple(suspicion) for suspicion in both] == [("q_shoulder", (2.0,)), ("m_shoulder", (4.0,))]
