"""The paper's Table 1, at places of the robot's own."""

import pytest

from estexp_jax.errors import InputError
from estexp_jax.physics.effects.catalogue.gravity_tilt import STEEPEST
from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.situations import TABLE, situation

EFFECTS = {
    1: ["motor_weakness"],
    2: ["body_mass"],
    3: ["part_lost"],
    4: ["part_lost", "sensor_gain"],
    5: ["sensor_gain"],
    6: ["joint_jam"],
    7: ["part_lost", "joint_jam"],
    8: ["part_lost", "joint_jam", "sensor_gain"],
    9: [],
    10: ["gravity_tilt"],
    11: ["neuron_fault"],
    12: ["tied_outputs"],
    13: ["body_mass"],
}


@pytest.mark.parametrize("number", TABLE)
def test_each_situation_is_its_row_of_the_table(quadruped: Robot, number: int) -> None:
    for seed in range(12):
        changes = situation(number, quadruped, seed)
        assert [change.effect for change in changes] == EFFECTS[number]
        assert changes == situation(number, quadruped, seed)


def test_places_vary_with_the_seed(quadruped: Robot) -> None:
    assert {situation(3, quadruped, seed)[0].name for seed in range(40)} == {"upper_f", "upper_l", "upper_b", "upper_r"}
    assert len({situation(1, quadruped, seed)[0].name for seed in range(60)}) == 8


def test_other_failures_are_not_on_the_lost_leg(quadruped: Robot) -> None:
    for seed in range(30):
        leg, jam, sensor = situation(8, quadruped, seed)
        assert {str(jam.name)[-2:], str(sensor.name)[-2:]}.isdisjoint({str(leg.name)[-2:]})


def test_amounts_are_the_papers(quadruped: Robot) -> None:
    assert situation(10, quadruped, 0) == (Change("gravity_tilt", None, {"angle": STEEPEST}),)
    (double,), (half,) = situation(2, quadruped, 4), situation(13, quadruped, 4)
    mass = {str(c.name): quadruped.model.body_mass[quadruped.index("body", str(c.name))] for c in (double, half)}
    assert double.parameters["dm"] == pytest.approx(mass[str(double.name)])
    assert half.parameters["dm"] == pytest.approx(-mass[str(half.name)] / 2)
    assert str(situation(5, quadruped, 7)[0].name).startswith("angle_")


def test_a_robot_without_legs_cannot_lose_one() -> None:
    robot = Robot.from_string(
        """<mujoco><worldbody><body name="cart"><joint name="rail" type="slide" axis="1 0 0"/><geom size="0.1"/></body>
        </worldbody><actuator><motor name="push" joint="rail"/></actuator><sensor><jointpos joint="rail"/></sensor>
        </mujoco>"""
    )
    with pytest.raises(InputError, match="there is no situation 14"):
        situation(14, robot, 0)
    with pytest.raises(InputError, match="an? (angle|second)"):
        situation(12, robot, 0)
