"""Guesses at what the columns of a log are, by their names."""

import pytest

from estexp_jax.physics.model.robot import Robot
from estexp_jax.recordings.templates.guess import guesses
from estexp_jax.recordings.templates.names import NamedColumn
from tests.physics.mixed_actuators import MIXED
from tests.versions import needs_mujoco_4

TWO = """
<mujoco><worldbody>
  <body><joint name="Pitch" axis="0 1 0"/><geom size="0.1"/>
    <body><joint name="Wrist_Pitch" axis="0 1 0"/><geom size="0.1"/></body></body>
</worldbody>
<actuator><position name="m1" joint="Pitch"/><position name="m2" joint="Wrist_Pitch"/></actuator>
<sensor><jointpos name="Pitch_pos" joint="Pitch"/><jointpos name="Wrist_Pitch_pos" joint="Wrist_Pitch"/>
<jointvel name="w1" joint="Pitch"/></sensor></mujoco>
"""


@pytest.mark.parametrize(
    ("names", "found"),
    [
        (
            ["timestamp_us", "command_Wrist_Pitch", "command_Pitch", "position_Pitch", "position_Wrist_Pitch"],
            {"time": "timestamp_us", "ctrl.m1": "command_Pitch", "ctrl.m2": "command_Wrist_Pitch"}
            | {"sensor.Pitch_pos": "position_Pitch", "sensor.Wrist_Pitch_pos": "position_Wrist_Pitch"},
        ),
        (["time", "goalPosition1", "goalPosition2"], {"ctrl.m1": "goalPosition1", "ctrl.m2": "goalPosition2"}),
        (["t", "cmd_a", "cmd_b", "cmd_c", "speed"], {"time": "t", "sensor.w1": "speed"}),
        (["ctrl.m1", "cmd_Pitch", "temperature"], {}),
        (["torque_enable_Pitch", "pos"], {"enable.m1": "torque_enable_Pitch"}),
    ],
)
def test_guesses(names, found):
    assert _guessed(Robot.from_string(TWO), names) == found


@needs_mujoco_4
def test_each_input_of_an_actuator_is_found_by_what_it_is():
    robot = Robot.from_string(MIXED, "mixed.xml")
    names = ["cmd_pos_elbow", "cmd_vel_elbow", "cmd_torque_push", "cmd_pos_wrist"]
    found = {"ctrl.pid.0": names[0], "ctrl.pid.1": names[1], "ctrl.push": names[2], "ctrl.servo": names[3]}
    assert _guessed(robot, names) == found


def _guessed(robot, names):
    """Our columns with those that were guessed; what was left open is left out."""
    every = guesses(robot, [NamedColumn(name) for name in names])
    return {ours: guess.column.name for ours, guess in every.items() if guess.column is not None}


def _arm(*joints, motor="position", names=""):
    """A chain of joints, each with a motor called `names` and its number, and an angle sensor."""
    bodies = "".join(f'<body><joint name="{joint}" axis="0 1 0"/><geom size=".1"/>' for joint in joints)
    motors = "".join(f'<{motor} name="{names}{k}" joint="{joint}"/>' for k, joint in enumerate(joints))
    sensors = "".join(f'<jointpos name="{joint}_s" joint="{joint}"/>' for joint in joints)
    xml = f"<mujoco><worldbody>{bodies}{'</body>' * len(joints)}</worldbody><actuator>{motors}</actuator>"
    return Robot.from_string(f"{xml}<sensor>{sensors}</sensor></mujoco>")


def _whole(robot, command, reading, joints):
    """The mapping of a log with a command and a reading of each joint, each by its name."""
    motors = {robot.names("joint")[robot.joint_of_actuator(k)]: m for k, m in enumerate(robot.names("actuator"))}
    found = {f"ctrl.{motors[joint]}": command.format(name) for joint, name in joints.items()}
    return found | {f"sensor.{joint}_s": reading.format(name) for joint, name in joints.items()}


@pytest.mark.parametrize(
    ("joints", "command", "reading", "spelled"),
    [
        ("shoulder elbow", "action.{}.pos", "observation.state.{}.pos", "{}"),  # LeRobot's info.json
        ("shoulder elbow", "/command/{}/position", "/joint_states/{}/position", "{}"),  # PlotJuggler
        ("shoulder elbow", "/cmd.position[{}]", "/joint_states.position[{}]", "{}"),  # JointState
        ("shoulder elbow", "cmd_{}", "{}", "{}"),  # bare names are readings
        ("shoulder_joint elbow_joint", "goal_{}", "q_{}", "short"),
        ("leftElbow rightElbow", "{}_target_position", "{}_position", "snake"),
        ("panda_joint1 panda_joint2", "tau_cmd_{}", "joint{}_pos", "number"),
        ("FL_hip FL_thigh", "des_{}_q", "{}_q", "lower"),
        ("shoulder elbow", "/arm/{}_position_controller/command.data", "/js.position[{}]", "{}"),  # ROS 1, Gazebo
        ("shoulder elbow", "/model/arm/joint/{}/0/cmd_pos.data", "/js.position[{}]", "{}"),  # Gazebo's own topics
        ("joint1 joint2", "/model/arm/joint/{}/0/cmd_pos.data", "/js.position[{}]", "{}"),
        ("hip_left hip_right", "{}_target", "{}_angle", "turned"),
        ("l_hip r_hip l_knee r_knee", "{}Cmd", "{}Pos", "side"),
        ("shoulder elbow", "{}_Soll", "{}_Ist", "{}"),
        ("shoulder elbow", "{}_cmd_filtered", "{}_pos_filtered", "{}"),
    ],
)
def test_joints_in_another_order_are_found_by_their_names(joints, command, reading, spelled):
    names = joints.split()
    spell = {"short": lambda n: n.split("_")[0], "number": lambda n: n[-1], "lower": str.lower}
    spell["turned"] = lambda n: "_".join(reversed(n.split("_")))
    spell["side"] = lambda n: {"l": "left", "r": "right"}[n[0]] + n[2:].title()
    spell["snake"] = lambda n: n.replace("E", "_e")
    own = {name: spell.get(spelled, str)(name) for name in names}
    robot = _arm(*names, motor="motor" if "tau" in command else "position", names="x")
    log = [text.format(own[name]) for name in reversed(names) for text in (command, reading)]
    log += ["/joint_states.header.stamp.sec", "/state.error.positions[elbow]", "/cmd.velocity[elbow]"]
    every = guesses(robot, [NamedColumn(name) for name in log])
    assert _guessed(robot, log) == _whole(robot, command, reading, own)
    assert all("by its n" in guess.why for guess in every.values())


def test_the_longest_name_at_the_end_counts():
    robot = _arm("pitch", "wrist_pitch", "pitch_2", names="m_a")
    log = ["cmd_pitch_2", "cmd_wrist_pitch", "cmd_pitch", "wrist_pitch_pos", "pitch_2_pos", "pitch_pos"]
    own = {joint: joint for joint in ("pitch", "wrist_pitch", "pitch_2")}
    assert _guessed(robot, log) == _whole(robot, "cmd_{}", "{}_pos", own)


@pytest.mark.parametrize(
    ("log", "found"),
    [
        # One of them bears the name of a joint, so order says nothing of the other.
        (
            ["cmd_elbow", "cmd_b", "pos_a", "pos_shoulder"],
            {"ctrl.m1": "cmd_elbow", "sensor.shoulder_s": "pos_shoulder"},
        ),
        # Foreign names in two orders contradict each other.
        (["cmd_pan", "cmd_lift", "pos_lift", "pos_pan"], {}),
        # The left or the right one?
        (["cmd_left_elbow", "cmd_right_elbow", "cmd_shoulder"], {"ctrl.m0": "cmd_shoulder"}),
        # A velocity is no position.
        (["cmd_vel_shoulder", "cmd_vel_elbow", "tau_shoulder", "tau_elbow"], {}),
        (["a_pos", "b_pos", "c_pos"], {}),
    ],
)
def test_what_is_in_doubt_is_left_open(log, found):
    assert _guessed(_arm("shoulder", "elbow", names="m"), log) == found


def test_order_is_told_where_it_is_all_there_is():
    robot = _arm("shoulder", "elbow", names="m")
    every = guesses(robot, [NamedColumn(name) for name in ("goal_1", "goal_2", "pan_pos", "lift_pos")])
    assert {ours: (guess.column.name, guess.why) for ours, guess in every.items() if guess.column} == {
        "ctrl.m0": ("goal_1", "by its order: check this"),
        "ctrl.m1": ("goal_2", "by its order: check this"),
        "sensor.shoulder_s": ("pan_pos", "by its order: check this"),
        "sensor.elbow_s": ("lift_pos", "by its order: check this"),
    }


@pytest.mark.parametrize(("first", "why"), [(0, "by its order"), (1, "by its number")])
def test_numbers_are_names_only_where_they_are_the_same_ones(first, why):
    robot = _arm("joint1", "joint2", names="joint")
    robot = _arm("joint2", "joint1", names="m")
    log = [NamedColumn(f"q{first + k}") for k in (1, 0)] + [NamedColumn(f"q{first + k}_cmd") for k in (0, 1)]
    every = guesses(robot, log)
    found = {ours: guess.column.name for ours, guess in every.items() if guess.column is not None}
    assert found["sensor.joint1_s"] == f"q{first}" and found["sensor.joint2_s"] == f"q{first + 1}"
    assert found["ctrl.m1"] == f"q{first}_cmd" and all(why in guess.why for guess in every.values())


def test_of_several_lists_the_one_of_as_many_values_is_taken():
    robot = _arm("shoulder", "elbow", names="m")
    columns = [NamedColumn("action", k) for k in range(2)] + [NamedColumn("wheel_action", k) for k in range(3)]
    every = guesses(robot, columns)
    assert {ours: guess.column for ours, guess in every.items()} == {f"ctrl.m{k}": columns[k] for k in range(2)}


def test_names_that_stand_elsewhere_in_the_log_count_as_names():
    robot = _arm("shoulder", "elbow", names="m")
    columns = [NamedColumn(f"/cmd.data[{k}]", None, name, "/j.joints") for k, name in enumerate(("elbow", "shoulder"))]
    every = guesses(robot, columns)
    assert {ours: guess.column for ours, guess in every.items()} == {"ctrl.m0": columns[1], "ctrl.m1": columns[0]}
    assert all("by the list of names in /j.joints" in guess.why for guess in every.values())


def test_values_of_a_list_are_taken_by_their_order():
    robot = _arm("shoulder", "elbow", names="m")
    every = guesses(
        robot, [NamedColumn("action", k) for k in range(2)] + [NamedColumn("state_pos", k) for k in range(3)]
    )
    assert {ours: guess.column for ours, guess in every.items()} == {
        "ctrl.m0": NamedColumn("action", 0),
        "ctrl.m1": NamedColumn("action", 1),
    }


@pytest.mark.parametrize(
    ("names", "time", "nanoseconds"),
    [
        (["x", "timestamp_us"], "timestamp_us", None),
        (["a_time", "timestamp"], "timestamp", None),
        (["header.stamp.sec", "header.stamp.nanosec"], "header.stamp.sec", "header.stamp.nanosec"),
        (["time_sec", "q"], "time_sec", None),
        (["sec", "nsec"], "sec", "nsec"),
        (["t [ms]"], "t [ms]", None),
    ],
)
def test_clocks(names, time, nanoseconds):
    guess = guesses(_arm("a"), [NamedColumn(name) for name in names])["time"]
    assert guess.column is not None and (guess.column.name, guess.nanoseconds) == (time, nanoseconds)


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("knee_speed_deg_s", "deg/s"),
        ("knee velocity [deg/sec]", "deg/s"),
        ("knee_deg_per_second", "deg/s"),
        ("knee_vel_degrees", "deg/s"),
        ("gyro_dps_knee", "deg/s"),
        ("knee_angle_deg_2", "deg"),
        ("knee_deg_smooth", "deg"),
        ("knee_mrad", "mrad"),
        ("slide_pos_cm", "cm"),
        ("slide_mm_s", "mm"),
        ("time_ms", "ms"),
        ("time_s", ""),
        ("knee_rad_s", ""),
    ],
)
def test_units_in_names(name, unit):
    assert NamedColumn(name).unit == unit
