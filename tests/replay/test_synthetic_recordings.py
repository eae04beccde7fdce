"""What a simulated robot logs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from estexp_jax.physics.effects.changes import parse_change
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recordings.bind import read_recording
from estexp_jax.replay.synthetic_recordings import RecordConfig, write_recordings
from estexp_jax.runs import open_run

FLYING = """
<mujoco><option timestep="0.01" gravity="0 0 -1"/><worldbody>
  <body><freejoint name="root"/><geom size="0.1" mass="1"/>
    <body pos="0.2 0 0"><joint name="arm" axis="0 1 0"/><geom size="0.05" pos="0.1 0 0" mass="0.2"/></body>
  </body></worldbody>
  <actuator><motor name="turn" joint="arm" gear="0.02"/></actuator>
</mujoco>"""


def test_without_sensors_a_floating_robot_logs_what_motion_capture_sees(tmp_path: Path) -> None:
    robot = Robot.from_string(FLYING, "flying.xml")
    write_recordings(robot, (), RecordConfig(duration=0.5, rate=50.0), open_run(tmp_path / "out"))
    log = read_recording(robot, tmp_path / "out" / "test_0.csv")
    assert np.isfinite(log.qpos).all() and np.isfinite(log.qvel[:, :6]).all()
    assert np.abs(np.linalg.norm(log.qpos[:, 3:7], axis=1) - 1.0).max() < 1e-6
    fallen = -0.5 * log.time**2  # the whole falls freely, whatever the arm does; it holds a sixth of the mass
    assert np.abs(log.qpos[:, 2] - fallen).max() < 0.02 and log.qpos[-1, 2] < -0.09
    assert np.abs(np.gradient(log.qpos[:, 2], log.time) - log.qvel[:, 2]).max() < 0.1


def test_torques_hold_an_upright_arm_around_its_home(tmp_path: Path) -> None:
    upright = """<mujoco><option timestep="0.01"/><worldbody><body><joint name="foot" axis="0 1 0" damping="0.1"/>
      <geom type="capsule" fromto="0 0 0 0 0 0.5" size="0.02" mass="1"/></body></worldbody>
      <actuator><motor name="low" joint="foot" ctrlrange="-9 9"/></actuator></mujoco>"""
    robot = Robot.from_string(upright, "upright.xml")
    change = parse_change("coulomb_friction@foot T=0.1", robot)
    write_recordings(robot, (change,), RecordConfig(duration=2.0, rate=50.0), open_run(tmp_path / "out"))
    for name, reach in (("train_0.csv", 0.36), ("train_1.csv", 0.36), ("test_0.csv", 0.54)):
        log = read_recording(robot, tmp_path / "out" / name)
        assert 0.1 < np.abs(log.qpos).max() < reach + 0.05
        assert 0.1 < np.abs(log.ctrl).max() < 9.0


ARM = """<body name="{0}" pos="{1} 0 0"><joint name="{0}" axis="0 1 0" damping="0.1"/>
  <geom type="capsule" fromto="0 0 0 0 0 -0.4" size="0.02" mass="1"/></body>"""


@pytest.mark.parametrize(
    ("apart", "flag", "usual"), [(0.9, "", True), (0.2, "", False), (0.2, '<flag contact="disable"/>', True)]
)
def test_arms_that_would_meet_move_less_far(tmp_path: Path, apart: float, flag: str, usual: bool) -> None:
    """A torque motor turns one, a servo with a gear the other; both hang."""
    arms, servo = ARM.format("left", 0) + ARM.format("right", apart), 'kp="5" kv="0.3" gear="2"'
    robot = Robot.from_string(
        f"""<mujoco><option timestep="0.01">{flag}</option><worldbody>{arms}</worldbody><actuator>
        <motor name="turn" joint="left"/><position name="servo" joint="right" {servo}/></actuator></mujoco>""",
        "arms.xml",
    )
    write_recordings(robot, (), RecordConfig(duration=2.0, rate=50.0, seed=43), open_run(tmp_path / "out"))
    logs = [read_recording(robot, tmp_path / "out" / name) for name in ("train_0.csv", "train_1.csv", "test_0.csv")]
    gaps = [apart - 0.04 - 0.4 * (np.sin(log.qpos[:, 1]) - np.sin(log.qpos[:, 0])) for log in logs]
    assert (min(gap.min() for gap in gaps) > 0.005) == (not flag)
    asked = [np.abs(log.ctrl[:, 1]).max() for log in logs[::2]]
    assert (asked == pytest.approx([0.36, 0.54], rel=0.02)) == usual
    assert asked[1] == pytest.approx(1.5 * asked[0], rel=0.02), "the test motion is the larger one still"
