"""Columns find their elements, and wrong ones are told with file, row and column."""

import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recordings.bind import bind_columns, column_names, read_recording
from estexp_jax.recordings.columns import Source
from estexp_jax.recordings.table import Table

NAN = np.nan


def _table(**changes):
    """A good log of the pendulum, with columns replaced, added, or dropped (None)."""
    columns = {"time": [0.0, 0.1, 0.3], "ctrl.servo.1": [1.0, 2.0, 3.0], "ctrl.actuator_1": [0.0, 0.0, 0.0]}
    columns |= {"sensor.angle": [0.1, 0.2, 0.3]} | changes
    return Table(
        "log.csv", {n: np.array(v, float) for n, v in columns.items() if v is not None}, {}, np.array([2, 3, 5])
    )


def _csv(path, header, *rows):
    path.write_text("\n".join([header, *rows]) + "\n")
    return path


def test_columns_find_their_elements(pendulum):
    table = _table(
        **{
            "sensor.sensor_1": [7.0, NAN, 9.0],
            "sensor.acc.2": [4.0, 5.0, 6.0],
            "qpos.hinge": [0.0, 1.0, 2.0],
            "qvel.joint_1": [3.0, 2.0, 1.0],
            "temperature": [20.0, 20.0, 20.0],
        }
    )
    recording = bind_columns(pendulum, table, role="test", settings={"joint.hinge.damping": 0.2})
    np.testing.assert_array_equal(recording.ctrl, [[1.0, 0.0], [2.0, 0.0], [3.0, 0.0]])
    np.testing.assert_array_equal(recording.enable, np.ones((3, 2)))
    expected = [[0.1, 7.0, NAN, NAN, 4.0], [0.2, NAN, NAN, NAN, 5.0], [0.3, 9.0, NAN, NAN, 6.0]]
    np.testing.assert_array_equal(recording.sensor, expected)
    np.testing.assert_array_equal(recording.qpos, [[0.0, NAN], [1.0, NAN], [2.0, NAN]])
    np.testing.assert_array_equal(recording.qvel, [[NAN, 3.0], [NAN, 2.0], [NAN, 1.0]])
    assert (recording.name, recording.role) == ("log.csv", "test")
    assert recording.settings == {"joint.hinge.damping": 0.2}
    assert recording.notes == ("ignored columns: temperature",)


def test_free_and_ball_joints_have_several_columns():
    xml = """<mujoco><worldbody><body name="b"><freejoint name="root"/><geom size=".1"/>
      <body><joint name="ball" type="ball"/><geom size=".1"/><body><joint name="h"/><geom size=".1"/></body></body>
      </body></worldbody></mujoco>"""
    robot = Robot.from_string(xml)
    names = column_names(robot)
    assert [n for n in names if n.startswith("qpos.")][6:] == [
        "qpos.root.6",
        *(f"qpos.ball.{k}" for k in range(4)),
        "qpos.h",
    ]
    columns = {"time": np.array([0.0, 1.0]), "qpos.ball.3": np.array([1.0, 2.0]), "qvel.h": np.array([3.0, 4.0])}
    recording = bind_columns(robot, Table("a.csv", columns))
    assert np.flatnonzero(np.isfinite(recording.qpos[0])).tolist() == [10]
    assert np.flatnonzero(np.isfinite(recording.qvel[0])).tolist() == [9]


def test_empty_commands_and_switches_hold_the_last(pendulum):
    table = _table(**{"ctrl.servo.1": [1.0, NAN, 3.0], "enable.servo.1": [NAN, 0.0, NAN]})
    recording = bind_columns(pendulum, table)
    np.testing.assert_array_equal(recording.ctrl[:, 0], [1.0, 1.0, 3.0])
    np.testing.assert_array_equal(recording.enable, [[1.0, 1.0], [0.0, 1.0], [0.0, 1.0]])


def test_rows_before_the_first_command_are_left_out_and_told(pendulum):
    table = _table(**{"ctrl.servo.1": [NAN, 2.0, NAN], "enable.servo.1": [0.0, NAN, NAN]})
    recording = bind_columns(pendulum, table)
    np.testing.assert_array_equal(recording.time, [0.1, 0.3])
    np.testing.assert_array_equal(recording.ctrl[:, 0], [2.0, 2.0])
    np.testing.assert_array_equal(recording.enable[:, 0], [0.0, 0.0])
    np.testing.assert_array_equal(recording.sensor[:, 0], [0.2, 0.3])
    assert recording.notes == ("1 rows (0.1 s) before the first command of servo.1 are left out",)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"time": None}, r"log\.csv: no column 'time'"),
        ({"time": [0.0, 0.2, 0.1]}, r"log\.csv, row 5, column 'time': time runs backwards: 0\.1 s after 0\.2 s"),
        ({"time": [0.0, 0.0, 0.1]}, r"log\.csv, row 3, column 'time': time stands still"),
        ({"time": [0.0, NAN, 0.1]}, r"log\.csv, row 3, column 'time': the time is empty"),
        ({"ctrl.servo.1": None}, r"log\.csv: no column 'ctrl\.servo\.1'.*columns are: time, ctrl\.actuator_1"),
        ({"ctrl.servo.1": [NAN, NAN, NAN]}, r"log\.csv: every command of ctrl\.servo\.1 is empty"),
        ({"ctrl.servo.1": [NAN, NAN, 1.0]}, r"log\.csv: has 1 rows from the first command of ctrl\.servo\.1 on"),
        (
            {"ctrl.knee": [1.0, 1.0, 1.0]},
            r"log\.csv, column 'ctrl\.knee'.*known are: ctrl\.servo\.1, ctrl\.actuator_1$",
        ),
        ({"sensor.acc": [1.0, 1.0, 1.0]}, r"log\.csv, column 'sensor\.acc'.*sensor\.acc\.0, sensor\.acc\.1"),
        ({"sensor.angle": None}, r"log\.csv: no reading.*sensor\.angle"),
        ({"sensor.angle": [NAN, NAN, NAN]}, r"log\.csv: no reading"),
        ({"sensor.angle": [0.0, 1.0, np.inf]}, r"log\.csv, row 5, column 'sensor\.angle': infinite"),
        (
            {"enable.servo.1": [1.0, 1.0, 64.0]},
            r"log\.csv, row 5, column 'enable\.servo\.1': enable\.servo\.1 is 64\.0",
        ),
        ({"sensor.angle": [0.0, 1.0]}, r"log\.csv, column 'sensor\.angle': has 2 rows, `time` has 3"),
    ],
)
def test_wrong_logs_name_the_place(pendulum, changes, message):
    with pytest.raises(InputError, match=message):
        bind_columns(pendulum, _table(**changes))


def test_one_row_is_no_recording(pendulum):
    columns = {"time": [0.0], "ctrl.servo.1": [0.0], "ctrl.actuator_1": [0.0], "sensor.angle": [0.0]}
    with pytest.raises(InputError, match="has 1 rows"):
        bind_columns(pendulum, Table("log.csv", {name: np.array(v) for name, v in columns.items()}))


def test_mapping_renames_scales_and_fills(pendulum):
    table = _table(**{"ctrl.actuator_1": None, "sensor.angle": None, "stamp": [0.0, 1e6, 2e6], "deg": [0.0, 90.0, NAN]})
    mapping = {
        "time": Source("stamp", scale=1e-6),
        "ctrl.actuator_1": Source(value=0.5),
        "sensor.angle": Source("deg", scale=np.pi / 180, offset=1.0),
    }
    recording = bind_columns(pendulum, table, mapping=mapping)
    np.testing.assert_allclose(recording.time, [0.0, 1.0, 2.0])
    np.testing.assert_array_equal(recording.ctrl, [[1.0, 0.5], [2.0, 0.5], [3.0, 0.5]])
    np.testing.assert_allclose(recording.sensor[:, 0], [1.0, 1.0 + np.pi / 2, NAN])
    assert recording.notes == ("ignored columns: time",)


def test_mapped_columns_are_named_as_in_the_log(pendulum):
    mapping = {"time": Source("stamp")}
    with pytest.raises(InputError, match=r"log\.csv, row 5, column 'stamp': time runs backwards"):
        bind_columns(pendulum, _table(stamp=[0.0, 2.0, 1.0]), mapping=mapping)
    with pytest.raises(InputError, match=r"log\.csv: no column 'stamp'; known are: time"):
        bind_columns(pendulum, _table(), mapping=mapping)
    with pytest.raises(InputError, match=r"mapping: 'ctrl\.knee' names nothing"):
        bind_columns(pendulum, _table(), mapping={"ctrl.knee": Source("time")})


def test_a_column_with_our_prefix_may_serve_as_a_source(pendulum):
    table = _table(**{"sensor.angle": None, "sensor.raw": [1.0, 2.0, 3.0]})
    recording = bind_columns(pendulum, table, mapping={"sensor.angle": Source("sensor.raw", scale=2.0)})
    np.testing.assert_array_equal(recording.sensor[:, 0], [2.0, 4.0, 6.0])


def test_text_matters_only_where_it_is_needed(pendulum, tmp_path):
    header = "time,ctrl.servo.1,ctrl.actuator_1,sensor.angle,state"
    path = _csv(tmp_path / "log.csv", header, "0,0,0,0.1,idle", "1,0,0,0.2,run")
    assert read_recording(pendulum, path).notes == ("ignored columns: state",)
    path = _csv(tmp_path / "log.csv", header, "0,0,0,0.1,idle", "1,0,0,hello,run")
    with pytest.raises(InputError, match=r"log\.csv, row 3, column 'sensor\.angle': 'hello' is not a number"):
        read_recording(pendulum, path)
