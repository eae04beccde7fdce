"""Logs cut at every tenth byte are read as far as they go, or refused in one message."""

import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recordings import read_recording
from estexp_jax.recordings.columns import Source
from estexp_jax.recordings.write import write_csv
from tests.recordings.readers.forms import write_mcap

MODEL = """<mujoco><worldbody><body><joint name="elbow" damping="1" armature=".1"/><geom size=".05"/></body></worldbody>
<actuator><position name="servo" joint="elbow" kp="40"/></actuator>
<sensor><jointpos name="angle" joint="elbow"/></sensor></mujoco>"""
ROWS = 40


def _csv(path, time, goal, position):
    write_csv(path, {"time": time, "ctrl.servo": goal, "sensor.angle": position})
    return None


def _mcap(path, time, goal, position):
    pytest.importorskip("mcap_ros2", reason="MCAP needs the extra `mcap`: pip install 'estexp_jax[mcap]'")
    write_mcap(path, time, goal, position)
    return {"ctrl.servo": Source("/goal.position[0]"), "sensor.angle": Source("/joint_states.position[elbow]")}


@pytest.mark.parametrize(("kind", "write"), [("csv", _csv), ("mcap", _mcap)])
def test_a_log_cut_anywhere(tmp_path, kind, write):
    (tmp_path / "arm.xml").write_text(MODEL)
    robot, time = Robot.from_xml(tmp_path / "arm.xml"), (np.arange(ROWS) * 0.01).round(3)
    goal, angle = np.sin(30 * time).round(4), np.cos(7 * time).round(4)
    path, cut = tmp_path / f"whole.{kind}", tmp_path / f"cut.{kind}"
    mapping = write(path, time, goal, angle)
    whole, rows, refused = path.read_bytes(), [], 0
    for stop in range(0, len(whole), 10):
        cut.write_bytes(whole[:stop])
        try:
            read = read_recording(robot, cut, mapping=mapping)
        except InputError as error:
            assert str(error).startswith(str(cut)) and "\n" not in str(error)
            refused += 1
            continue
        rows.append(read.rows)
        np.testing.assert_allclose(read.time, time[: read.rows], rtol=0, atol=1e-9)
        np.testing.assert_array_equal(read.ctrl[:, 0], goal[: read.rows])
        seen = np.isfinite(read.sensor[:, 0])  # the last command may have come without its reading
        assert seen[:-1].all()
        np.testing.assert_array_equal(read.sensor[seen, 0], angle[: read.rows][seen])
    assert rows == sorted(rows) and rows[-1] >= ROWS - 1 and refused < len(whole) // 20
