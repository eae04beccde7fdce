"""What `ExplainedSimulator.rollout` simulates: contacts that occur in a motion, and no others."""

from unittest.mock import patch

import numpy as np
import pytest

from estexp_jax.physics.model.robot import Robot
from estexp_jax.replay import explained_simulator as module
from estexp_jax.replay.explained_simulator import ExplainedSimulator

LEGS = """
<mujoco><option timestep="0.004"/><worldbody>
  <body name="left">
    <joint name="l" axis="0 1 0" damping="0.2"/><geom size="0.05" mass="1" pos="0 0 -0.5"/>
  </body>
  <body name="right" pos="0.3 0 0">
    <joint name="r" axis="0 1 0" damping="0.2"/><geom size="0.05" mass="1" pos="0 0 -0.5"/>
  </body></worldbody>
  <actuator><motor name="l" joint="l"/><motor name="r" joint="r"/></actuator>
</mujoco>"""


@pytest.mark.parametrize(
    ("torque", "engines"),
    [(0.3, ["lanes"]), (0.52, ["lanes"]), (3.0, ["lanes", "c"])],
    ids=["apart", "all but touching", "touching"],
)
def test_a_contact_is_simulated_only_where_it_occurs(torque: float, engines: list[str]) -> None:
    legs = Robot.from_string(LEGS, "legs.xml")
    used, make = [], module.open_loop_simulator

    def noting(*arguments, **options):
        found = make(*arguments, **options)
        used.append(found.choice.engine)
        return found

    commands = np.tile([-torque, torque], (100, 1))
    with patch.object(module, "open_loop_simulator", noting):
        traces = ExplainedSimulator(legs, ()).rollout(commands, period=0.01)
    assert used == engines
    feet = [x + 0.5 * -np.sin(traces.qpos[:, i]) for i, x in enumerate((0.0, 0.3))]
    gap = feet[1] - feet[0] - 0.1
    assert gap.min() > -0.02 and (gap.min() < 0.005) == (torque > 1.0)
    assert (gap.min() < 0.02) == (torque > 0.4)
