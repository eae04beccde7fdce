"""The manifest: a log described instead of converted."""

import numpy as np
import pyarrow
import pytest
from pyarrow import parquet

from estexp_jax.errors import InputError
from estexp_jax.recordings import read_manifest

MANIFEST = """
model = "pendulum.xml"

[columns]
time = { column = "stamp", unit = "us" }
"ctrl.servo.1" = { column = "goal", unit = "deg", scale = -1.0, offset = 0.5 }
"ctrl.actuator_1" = { value = 0.25 }
"sensor.angle" = "position"
"enable.servo.1" = "on"

[[recording]]
file = "logs/a.csv"
[recording.set]
"actuator.servo.1.kp" = 3
"actuator.servo.1.forcerange" = [-1, 1.5]

[[recording]]
file = "logs/b.csv"
role = "test"
"""
LOG = "stamp,goal,position,on,temp,sensor.sensor_1\n0,90,0.1,1,20,7\n1000,180,,0,20,8\n"


@pytest.fixture
def folder(tmp_path, pendulum_xml):
    (tmp_path / "pendulum.xml").write_text(pendulum_xml)
    (tmp_path / "logs").mkdir()
    for name in ("a.csv", "b.csv"):
        (tmp_path / "logs" / name).write_text(LOG)
    (tmp_path / "recordings.toml").write_text(MANIFEST)
    return tmp_path


def _replaced(folder, old, new, text=MANIFEST):
    assert text.count(old) >= 1
    (folder / "recordings.toml").write_text(text.replace(old, new, 1))
    return folder / "recordings.toml"


def test_a_recording_may_be_of_the_healthy_robot(folder):
    path = _replaced(folder, 'role = "test"', 'role = "healthy"')
    assert [r.role for r in read_manifest(path).recordings] == ["train", "healthy"]


def test_manifest_is_read_relative_to_itself(folder):
    manifest = read_manifest(folder / "recordings.toml")
    assert manifest.model == folder / "pendulum.xml"
    assert manifest.robot.names("actuator") == ("servo.1", "actuator_1")
    first, second = manifest.recordings
    assert [(r.name, r.role) for r in (first, second)] == [("a.csv", "train"), ("b.csv", "test")]
    assert first.settings == {"actuator.servo.1.kp": 3.0, "actuator.servo.1.forcerange": (-1.0, 1.5)}
    assert second.settings == {}
    np.testing.assert_allclose(first.time, [0.0, 0.001])
    np.testing.assert_allclose(first.ctrl, [[0.5 - np.pi / 2, 0.25], [0.5 - np.pi, 0.25]])
    np.testing.assert_array_equal(first.enable, [[1.0, 1.0], [0.0, 1.0]])
    np.testing.assert_array_equal(first.sensor[:, :2], [[0.1, 7.0], [np.nan, 8.0]])
    assert first.notes == ("ignored columns: temp",)


def test_list_columns_by_index(folder):
    parquet.write_table(
        pyarrow.table({"time": [0.0, 0.1], "action": [[1.0, 2.0], [3.0, 4.0]], "state": [[5.0, 6.0], [7.0, 8.0]]}),
        folder / "a.parquet",
    )
    (folder / "recordings.toml").write_text("""
model = "pendulum.xml"
[columns]
"ctrl.servo.1" = { column = "action", index = 0 }
"ctrl.actuator_1" = { column = "action", index = 1 }
"sensor.angle" = { column = "state", index = 1 }
[[recording]]
file = "a.parquet"
""")
    (recording,) = read_manifest(folder / "recordings.toml").recordings
    np.testing.assert_array_equal(recording.ctrl, [[1.0, 2.0], [3.0, 4.0]])
    np.testing.assert_array_equal(recording.sensor[:, 0], [6.0, 8.0])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('model = "pendulum.xml"', "model = ", r"recordings\.toml: is not valid TOML: .*line 2"),
        ('model = "pendulum.xml"', "", r"recordings\.toml: has no `model`"),
        ('"pendulum.xml"', "3", r"recordings\.toml: model is 3, not a text"),
        ('"pendulum.xml"', '"none.xml"', r"recordings\.toml, model: no such MJCF file .*none\.xml"),
        ("[columns]", "[colums]", r"recordings\.toml: unknown key 'colums'; known are: model, columns, recording"),
        ("time = ", "tine = ", r"recordings\.toml, \[columns\]: 'tine' names nothing"),
        ('"ctrl.actuator_1"', '"ctrl.knee"', r"\[columns\]: 'ctrl\.knee' names nothing.*known are: ctrl\.servo\.1"),
        ('"sensor.angle" =', "sensor.angle =", r'\[columns\]: \'sensor\' is a nested table; .*"sensor\.angle" = '),
        (
            'unit = "us"',
            'unit = "fortnight"',
            r"\[columns\], 'time': unknown unit 'fortnight'; known are: rad, mrad, deg, turn",
        ),
        ('unit = "us"', 'factor = "us"', r"\[columns\], 'time': unknown key 'factor'"),
        ('{ column = "stamp", unit = "us" }', "{ value = 0.0 }", r"\[columns\]: time cannot be a constant"),
        ("scale = -1.0", 'scale = "x"', r"'ctrl\.servo\.1', scale: is 'x', not a finite number"),
        ('= "position"', "= 3", r"'sensor\.angle': is 3, not a column"),
        ('= "position"', "= { scale = 3 }", r"'sensor\.angle': needs either `column` or `value`"),
        ('= "position"', '= { column = "position", index = -1 }', r"'sensor\.angle': index is -1"),
        ('= "position"', '= "positon"', r"a\.csv: no column 'positon'; known are: stamp, goal, position"),
        ('file = "logs/b.csv"', "", r"\[\[recording\]\] 2: has no `file`"),
        ("logs/b.csv", "logs/c.csv", r"recordings\.toml, \[\[recording\]\] 2: no such recording '.*c\.csv'"),
        ('role = "test"', 'role = "exam"', r"\[\[recording\]\] 2: role is 'exam'; known are: train, test"),
        ('role = "test"', 'roll = "test"', r"2: unknown key 'roll'; known are: file, episode, clock, role, set"),
        ('role = "test"', "episode = -1", r"\[\[recording\]\] 2: episode is -1; a whole number from 0"),
        ('role = "test"', "episode = 1", r"b\.csv: has no episodes"),
        ('role = "test"', 'clock = "sun"', r"\[\[recording\]\] 2: clock is 'sun'; known are: log, publish, header"),
        ('role = "test"', 'clock = "header"', r"b\.csv: has one clock"),
        ("logs/b.csv", "a\\u0000.csv", r"2: no such recording"),
        ("logs/b.csv", "../" * 40 + "etc/passwd", r"unknown kind of recording|no such recording"),
        ("logs/b.csv", "b" * 5000 + ".csv", r"2: no such recording"),
        (
            '"actuator.servo.1.kp" = 3',
            '"actuator.knee.kp" = 3',
            r"\[\[recording\]\] 1, set, 'actuator\.knee\.kp': there is no",
        ),
        ('"actuator.servo.1.kp" = 3', "actuator.servo.kp = 3", r"1, set, 'actuator': is a nested table"),
        ('"actuator.servo.1.kp" = 3', '"actuator.servo.1.kp" = true', r"set, 'actuator\.servo\.1\.kp': is True, not a"),
    ],
)
def test_wrong_manifests_name_the_place(folder, old, new, message):
    with pytest.raises(InputError, match=message):
        read_manifest(_replaced(folder, old, new))


@pytest.mark.parametrize(
    "more",
    [
        ".".join("a" * 18) + " = 1",
        "[" + ".".join("a" * 18) + "]",
        "x = " + "[" * 17 + "]" * 17,
        "x = " + "[\n" * 17 + "]\n" * 17,
        "x = { a = { " + ".".join("a" * 18) + " = 1 } }",
    ],
)
def test_nesting_without_end_is_refused_before_it_is_parsed(folder, more):
    (folder / "recordings.toml").write_text(f"{more}\n{MANIFEST}")
    with pytest.raises(InputError, match="recordings.toml: line [0-9]+ is nested more than 16 deep"):
        read_manifest(folder / "recordings.toml")


def test_dots_and_brackets_in_texts_do_not_count(folder):
    dots = "a." * 20 + "[[[{{{" * 5
    note = f'# {dots}\nx = "{dots}\\"{dots}"\ny = \'{dots}\'\nz = """\n{dots}\n"""\n'
    (folder / "recordings.toml").write_text(f"{note}{MANIFEST}")
    with pytest.raises(InputError, match="'x'"):  # parsed: an unknown key
        read_manifest(folder / "recordings.toml")


def test_manifest_without_recordings_and_no_manifest(folder):
    with pytest.raises(InputError, match=r"recordings\.toml: lists no recordings"):
        read_manifest(_replaced(folder, MANIFEST, 'model = "pendulum.xml"'))
    with pytest.raises(InputError, match=r"none\.toml: no such manifest"):
        read_manifest(folder / "none.toml")


def test_model_that_does_not_compile_names_its_file(folder):
    xml = (folder / "pendulum.xml").read_text()
    (folder / "pendulum.xml").write_text(xml.replace('joint="hinge" kp', 'joint="none" kp'))
    with pytest.raises(InputError, match=r"pendulum\.xml: the MJCF does not compile: .*none"):
        read_manifest(folder / "recordings.toml")


def test_time_running_backwards_names_file_row_and_their_column(folder):
    (folder / "logs" / "b.csv").write_text(LOG + "500,0,0,1,20,0\n")
    with pytest.raises(InputError, match=r"b\.csv, row 4, column 'stamp': time runs backwards"):
        read_manifest(folder / "recordings.toml")


def test_real_servo_recordings(real_data, tmp_path):
    data = real_data / "xl330"
    (tmp_path / "recordings.toml").write_text(f"""
model = '{data / "nominal.xml"}'
[columns]
time = "timestamp"
"ctrl.servo" = "goal_position"
"sensor.angle" = "position"
"enable.servo" = "torque_enable"
[[recording]]
file = '{data / "kp100_lift_and_drop.csv"}'
[[recording]]
file = '{data / "kp800_sin_sin.csv"}'
role = "test"
[recording.set]
"actuator.servo.kp" = 1.7736
""")
    dropped, swung = read_manifest(tmp_path / "recordings.toml").recordings
    assert dropped.enable.min() == 0.0 and dropped.enable.max() == 1.0  # the motor is cut: free fall
    assert 180 < swung.rate < 200 and 5.5 < swung.duration < 6.5
    # The encoder has 4096 steps a turn.
    np.testing.assert_allclose(
        np.round(swung.sensor / (2 * np.pi / 4096)) * (2 * np.pi / 4096), swung.sensor, atol=1e-6
    )
