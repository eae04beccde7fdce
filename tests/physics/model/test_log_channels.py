"""Channels of a log: one number a row each, by the element's name where it is that of one of them only."""

from estexp_jax.physics.model.robot import Robot

XML = """<mujoco><worldbody>
<body><joint name="a" axis="0 1 0"/><geom size=".1"/><body><joint name="b" axis="0 1 0"/><geom size=".1"/></body></body>
</worldbody><actuator><position name="a" joint="a"/><motor name="mb" joint="b"/></actuator>
<sensor><jointpos name="a" joint="a"/><jointvel name="speed" joint="a"/><velocimeter name="v" site="s"/></sensor>
</mujoco>""".replace('<geom size=".1"/></body></body>', '<site name="s"/><geom size=".1"/></body></body>')


def test_each_has_a_name_of_its_own_and_its_place_in_a_recording():
    channels = Robot.from_string(XML).channels
    assert {name: (c.table, c.column, c.joint) for name, c in channels.items()} == {
        "sensor.a": ("sensor", 0, 0),
        "speed": ("sensor", 1, 0),
        "b": ("qpos", 1, 1),
        "ctrl.a": ("ctrl", 0, 0),
        "mb": ("ctrl", 1, 1),
    }
    assert [name for name, c in channels.items() if c.measures_position] == ["sensor.a", "b"]
    assert channels["b"].ours == "qpos.b" and channels["sensor.a"].ours == "sensor.a"


def test_they_are_names_like_those_of_elements():
    robot = Robot.from_string(XML)
    assert robot.names("channel")[robot.index("channel", "mb")] == "mb"
