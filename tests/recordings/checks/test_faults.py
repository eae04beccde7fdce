"""Recordings made bad: each fault is found and named, and a good recording has none."""

from dataclasses import replace

import numpy as np
import pytest

from estexp_jax.cli.main import main
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recordings import read_recording
from estexp_jax.recordings.checks import excitation
from estexp_jax.recordings.checks.inspect import judge
from estexp_jax.recordings.columns import Source
from estexp_jax.recordings.write import write_csv

ARM = """
<mujoco model="arm">
  <worldbody><body><joint name="elbow" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 -.2" size=".01"/></body>
  </worldbody>
  <actuator><position name="servo" joint="elbow" kp="2" ctrlrange="-1.5 1.5"/></actuator>
  <sensor><jointpos name="angle" joint="elbow"/><jointvel name="rate" joint="elbow"/></sensor>
</mujoco>
"""
STEP = 2 * np.pi / 4096
SERVO = {"time": "time", "ctrl.servo": "goal_position", "sensor.angle": "position", "enable.servo": "torque_enable"}


def _log(motion=1.0, seconds=10.0):
    """A servo that follows a sweep and some steps 30 ms later, at 200 Hz on a slightly uneven clock."""
    random = np.random.default_rng(7)
    time = np.cumsum(np.clip(0.005 + 2e-4 * random.standard_normal(int(seconds * 200)), 0.004, 0.006))
    time -= time[0]

    def goal(t):
        t = np.maximum(t, 0.0)
        return motion * (0.7 * np.sin(2 * np.pi * (0.2 + 0.05 * t) * t) + 0.4 * (np.floor(t / 2.5) % 2))

    shifts = np.linspace(0.0, 0.06, 25)
    angle = np.mean([goal(time - shift) for shift in shifts], axis=0)
    rate = np.gradient(angle, time)
    return {
        "time": time,
        "ctrl.servo": goal(time),
        "sensor.angle": np.round(angle / STEP) * STEP,
        "sensor.rate": np.round(rate / 0.02) * 0.02,
    }


def _changed(log, name, function):
    return log | {name: function(log[name].copy())}


def _put(where, value):
    def change(values):
        values[where] = value
        return values

    return change


def _held(every):
    return lambda values: values[(np.arange(len(values)) // every) * every]


def _shifted(log, name, seconds):
    return log | {name: np.interp(log["time"] + seconds, log["time"], log[name])}


def _stood(log, share=0.15):
    """Stuck where the command moves most: the sensor shows one value for a while."""
    length = int(share * len(log["time"]))
    spans = [np.ptp(log["ctrl.servo"][i : i + length // 2]) for i in range(len(log["time"]) - length)]
    start = int(np.argmax(spans))
    return _changed(log, "sensor.angle", _put(slice(start, start + length), log["sensor.angle"][start]))


def _spiked(log):
    rows = np.linspace(50, len(log["time"]) - 50, 5).astype(int)
    return _changed(log, "sensor.angle", lambda v: _put(rows, v[rows] + 0.8 * np.ptp(v))(v))


def _twice(log):
    return {name: np.insert(values, 101, values[100]) for name, values in log.items()}


def _backwards(log):
    return _changed(log, "time", _put(slice(300, 310), log["time"][280]))


def _cut(values):
    low, high = np.nanpercentile(values, [15, 85])
    return np.clip(values, low, high)


def _paused(log):
    return _changed(log, "time", lambda t: t + 0.7 * (np.arange(len(t)) > len(t) // 2))


def _jittered(log):
    steps = np.diff(log["time"]) * np.random.default_rng(3).choice([0.3, 1.7], len(log["time"]) - 1)
    return log | {"time": np.concatenate([[0.0], np.cumsum(steps)])}


def _dropped(log):
    return _changed(log, "sensor.angle", _put(slice(700, 760), np.nan))


def _still(log):
    return {name: values if name == "time" else np.full(len(values), 0.1) for name, values in log.items()}


BAD = {
    "time stands still": (_twice, "time: ", "stands still at 1 rows (first: bad.csv, row 103"),
    "time runs backwards": (_backwards, "time: ", "runs backwards at 1 rows (first: bad.csv, row 302"),
    "a gap of the clock": (_paused, "clock_gap", "the longest 0.7"),
    "an uneven clock": (_jittered, "clock_jitter", "the clock is uneven"),
    "time in ms": (lambda log: _changed(log, "time", lambda t: 1e3 * t), "time_unit", "another unit"),
    "angle in degrees": (lambda log: _changed(log, "sensor.angle", np.degrees), "degrees", 'unit = "deg"'),
    "command in degrees": (
        lambda log: _changed(log, "ctrl.servo", np.degrees),
        "degrees",
        "is it in degrees",
    ),
    "raw ticks": (
        lambda log: _changed(log, "sensor.angle", lambda v: np.round(v / STEP) + 2048.0),
        "ticks",
        "raw encoder ticks",
    ),
    "wrong sign": (lambda log: _changed(log, "sensor.angle", np.negative), "sign", "scale = -1.0"),
    "a stuck sensor": (_stood, "stuck", "stands still from"),
    "a sensor read too seldom": (lambda log: _changed(log, "sensor.angle", _held(4)), "stale", "repeats the reading"),
    "a coarse encoder": (
        lambda log: _changed(log, "sensor.angle", lambda v: np.round(v / 0.1) * 0.1),
        "coarse_encoder",
        "steps of its encoder",
    ),
    "a cut-off reading": (lambda log: _changed(log, "sensor.angle", _cut), "clipped", "is cut off at"),
    "a saturated command": (
        lambda log: _changed(log, "ctrl.servo", lambda v: np.clip(2.5 * v, -1.5, 1.5)),
        "saturation",
        "at or beyond its limits",
    ),
    "readings from the future": (lambda log: _shifted(log, "sensor.angle", 0.2), "ahead", "before its command"),
    "late readings": (lambda log: _shifted(log, "sensor.angle", -0.25), "late", "follows its command 0.2"),
    "spikes": (_spiked, "spikes", "5 single readings jump"),
    "dropouts": (_dropped, "dropouts", "gaps without a sample"),
    "no motion": (_still, "still", "does not move"),
    "speed in degrees": (
        lambda log: _changed(log, "sensor.rate", np.degrees),
        "speed_unit",
        "times the slope of sensor.angle",
    ),
}


def _judged(log, folder, robot):
    write_csv(folder / "bad.csv", log)
    return judge(robot, read_recording(robot, folder / "bad.csv", mend=True))


@pytest.fixture(scope="module")
def arm():
    return Robot.from_string(ARM, "arm.xml")


def test_a_good_recording_has_no_faults(arm, tmp_path):
    judged = _judged(_log(), tmp_path, arm)
    assert judged["faults"] == [] and judged["notes"] == []
    assert judged["commands"]["servo"]["lag_s"] == pytest.approx(0.03, abs=0.006)
    assert judged["readings"]["sensor.angle"]["step"] == pytest.approx(STEP)
    assert judged["joints"]["elbow"]["tells"] == dict.fromkeys(excitation.SUSPECTS, True)
    assert list(excitation.missing([judged, judged])) == []


@pytest.mark.parametrize("how", BAD)
def test_each_fault_is_found_and_named(arm, tmp_path, how, monkeypatch):
    monkeypatch.chdir(tmp_path)
    spoil, kind, told = BAD[how]
    judged = _judged(spoil(_log()), type(tmp_path)(), arm)
    said = judged["notes"] + [f"[{fault['kind']}] {fault['name']}: {fault['sentence']}" for fault in judged["faults"]]
    assert any(kind in sentence and told in sentence for sentence in said), said


def test_faults_reach_the_terminal(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.xml").write_text(ARM)
    write_csv(tmp_path / "bad.csv", _backwards(_spiked(_log())))
    assert main(["check", "arm.xml", "bad.csv"]) == 0
    shown = capsys.readouterr().out
    assert "runs backwards" in shown and "jump away" in shown and "to record: one recording only" in shown


@pytest.mark.parametrize(
    ("motion", "lack"),
    [
        (lambda t: 1.2 * np.abs((t / 4) % 2 - 1), "slowly and fast"),
        (lambda t: 0.1 * t, "hardly turns round"),
        (lambda t: 0.1 * np.sin(9 * t), "narrow range"),
        (lambda t: 0.8 * np.sin(0.5 * t), "never changes quickly"),
    ],
)
def test_what_a_motion_cannot_tell_is_told(arm, tmp_path, motion, lack):
    time = np.arange(0.0, 16.0, 0.01)
    judged = _judged({"time": time, "ctrl.servo": motion(time), "sensor.angle": motion(time - 0.02)}, tmp_path, arm)
    assert any(lack in sentence for sentence in excitation.missing([judged, judged]))


@pytest.mark.parametrize("how", [how for how in BAD if how not in ("speed in degrees", "a saturated command")])
def test_faults_put_into_real_recordings_are_found(real_data, tmp_path, monkeypatch, how):
    monkeypatch.chdir(tmp_path)
    robot = Robot.from_xml(real_data / "xl330" / "nominal.xml")
    mapping = {ours: Source(column=theirs) for ours, theirs in (SERVO | {"time": "timestamp"}).items()}
    good = read_recording(robot, real_data / "xl330" / "kp800_sin_time_square.csv", mapping=mapping)
    before = judge(robot, good)
    log = {"time": good.time - good.time[0], "ctrl.servo": good.ctrl[:, 0], "sensor.angle": good.sensor[:, 0]}
    spoil, kind, told = BAD[how]
    judged = _judged(spoil(log), type(tmp_path)(), replace(robot))
    said = judged["notes"] + [f"[{fault['kind']}] {fault['name']}: {fault['sentence']}" for fault in judged["faults"]]
    assert kind not in {fault["kind"] for fault in before["faults"]}
    loosely = told.split("(")[0] if "time" in how else kind
    assert any(loosely in sentence for sentence in said), said
