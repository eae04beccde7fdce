"""A good log of a servo, ways to corrupt it, and the check of both; shared by the tests of the checks."""

from dataclasses import replace

import numpy as np

from estexp_jax.physics.model.robot import Robot
from estexp_jax.recordings import read_recording
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


def servo_log(motion=1.0, seconds=10.0):
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


def changed(log, name, function):
    return log | {name: function(log[name].copy())}


def put(where, value):
    def change(values):
        values[where] = value
        return values

    return change


def hold_samples(every):
    return lambda values: values[(np.arange(len(values)) // every) * every]


def shifted(log, name, seconds):
    return log | {name: np.interp(log["time"] + seconds, log["time"], log[name])}


def with_stuck_sensor(log, share=0.15):
    """Stuck where the command moves most: the sensor shows one value for a while."""
    length = int(share * len(log["time"]))
    spans = [np.ptp(log["ctrl.servo"][i : i + length // 2]) for i in range(len(log["time"]) - length)]
    start = int(np.argmax(spans))
    return changed(log, "sensor.angle", put(slice(start, start + length), log["sensor.angle"][start]))


def with_spikes(log):
    rows = np.linspace(50, len(log["time"]) - 50, 5).astype(int)
    return changed(log, "sensor.angle", lambda v: put(rows, v[rows] + 0.8 * np.ptp(v))(v))


def with_repeated_time(log):
    return {name: np.insert(values, 101, values[100]) for name, values in log.items()}


def with_reversed_time(log):
    return changed(log, "time", put(slice(300, 310), log["time"][280]))


def clip(values):
    low, high = np.nanpercentile(values, [15, 85])
    return np.clip(values, low, high)


def with_pause(log):
    return changed(log, "time", lambda t: t + 0.7 * (np.arange(len(t)) > len(t) // 2))


def with_jitter(log):
    steps = np.diff(log["time"]) * np.random.default_rng(3).choice([0.3, 1.7], len(log["time"]) - 1)
    return log | {"time": np.concatenate([[0.0], np.cumsum(steps)])}


def with_dropouts(log):
    return changed(log, "sensor.angle", put(slice(700, 760), np.nan))


def without_motion(log):
    return {name: values if name == "time" else np.full(len(values), 0.1) for name, values in log.items()}


def check(log, folder, robot):
    """Write a log and check it."""
    write_csv(folder / "bad.csv", log)
    return judge(robot, read_recording(robot, folder / "bad.csv", mend=True))


def all_sentences(result):
    """All notes and faults of a check, as texts with their kind."""
    return result["notes"] + [f"[{fault['kind']}] {fault['name']}: {fault['sentence']}" for fault in result["faults"]]


def assert_found(fault, robot, folder):
    """The fault (corrupt, kind, part of the sentence) put into the good log is reported."""
    corrupt, kind, text = fault
    found = all_sentences(check(corrupt(servo_log()), folder, robot))
    assert any(kind in sentence and text in sentence for sentence in found), found


def assert_found_in_real(fault, real_data, folder, *, by_text=False):
    """The fault put into a recording of a real servo is reported, and was not there before."""
    robot = Robot.from_xml(real_data / "xl330" / "nominal.xml")
    mapping = {ours: Source(column=theirs) for ours, theirs in (SERVO | {"time": "timestamp"}).items()}
    good = read_recording(robot, real_data / "xl330" / "kp800_sin_time_square.csv", mapping=mapping)
    corrupt, kind, text = fault
    assert kind not in {found["kind"] for found in judge(robot, good)["faults"]}
    log = {"time": good.time - good.time[0], "ctrl.servo": good.ctrl[:, 0], "sensor.angle": good.sensor[:, 0]}
    found = all_sentences(check(corrupt(log), folder, replace(robot)))
    assert any((text.split("(")[0] if by_text else kind) in sentence for sentence in found), found
