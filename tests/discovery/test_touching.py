"""Test recordings have no say in which contacts are left out of what is fitted; what is shown of them may touch."""

import numpy as np

from estexp_jax.discovery.comparison import problem_of, shown_of
from estexp_jax.discovery.diagnosis import Case, ExplainConfig
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from tests.physics.model.test_clearance import LEGS, path

SENSORS = '<sensor><jointpos name="ql" joint="l"/><jointpos name="qr" joint="r"/></sensor></mujoco>'
CONFIG = ExplainConfig(window=0.25, most=1, effects=("viscous_friction",), engine="mjx")


def recording(swing: float, role: str) -> Recording:
    angles = path(swing)
    n, nothing = len(angles), np.full(angles.shape, np.nan)
    return Recording(
        f"{role}_{swing}.csv", np.arange(n) / 100.0, np.zeros((n, 2)), np.ones((n, 2)), angles, nothing, nothing, role
    )


def test_only_training_recordings_decide_what_is_left_out_of_fits():
    robot = Robot.from_string(LEGS.replace("</mujoco>", SENSORS), "legs.xml")
    for near, shown in ((0.1, 3), (0.3, 2)):  # the floor is far below both legs
        recordings = (recording(0.1, "train"), recording(0.12, "train"), recording(near, "test"))
        case = Case(robot, recordings, (robot,) * 3)
        whole = problem_of(case, CONFIG, {})
        assert whole.replayer.robot.model.nexclude == 3
        assert shown_of(case, CONFIG, whole).replayer.robot.model.nexclude == shown
