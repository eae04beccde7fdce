"""Commands of actuators with several inputs, under their own names or one for all."""

import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.physics.model.actuators import HAS_DECLARED_INPUTS
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recordings.bind import bind_columns, column_names
from estexp_jax.recordings.first_inputs import several_inputs
from estexp_jax.recordings.table import Table
from tests.physics.mixed_actuators import MIXED

if not HAS_DECLARED_INPUTS:
    pytest.skip("MuJoCo before 4 has no such motors", allow_module_level=True)
ROBOT = Robot.from_string(MIXED, "mixed.xml")
INPUTS = ("turn.0", "turn.1", "turn.2", "pid.0", "pid.1", "push", "servo")


def table(*commands: str) -> Table:
    columns = {"time": np.array([0.0, 0.1, 0.2]), "sensor.bends": np.zeros(3)}
    columns |= {name: np.full(3, i + 1.0) for i, name in enumerate(commands)}
    return Table("log.csv", columns)


def test_each_input_has_a_column_and_each_motor_a_switch() -> None:
    names = column_names(ROBOT)
    assert tuple(n for n in names if n.startswith("ctrl.")) == tuple(f"ctrl.{name}" for name in INPUTS)
    switches = tuple(f"enable.{name}" for name in ROBOT.names("actuator"))
    assert tuple(n for n in names if n.startswith("enable.")) == switches
    read = bind_columns(ROBOT, table(*(f"ctrl.{name}" for name in INPUTS)))
    assert read.ctrl[0].tolist() == [1, 2, 3, 4, 5, 6, 7] and read.enable.shape == (3, 5)


def test_one_column_is_the_first_input_and_the_others_are_zero_and_told() -> None:
    read = bind_columns(ROBOT, table("ctrl.turn", "ctrl.pid", "ctrl.pid.1", "ctrl.push", "ctrl.servo"))
    assert read.ctrl[0].tolist() == [1, 0, 0, 2, 3, 4, 5]
    assert read.notes == (
        "ctrl.turn is taken as ctrl.turn.0; ctrl.turn.1, ctrl.turn.2 as 0",
        "ctrl.pid is taken as ctrl.pid.0",
    )


def test_missing_and_unknown_inputs_are_named() -> None:
    with pytest.raises(InputError, match=r"no column 'ctrl\.pid\.1'"):
        bind_columns(ROBOT, table("ctrl.turn", "ctrl.pid.0", "ctrl.push", "ctrl.servo"))
    with pytest.raises(InputError, match=r"'ctrl\.brake' names nothing on this robot; known are: ctrl\.turn\.0"):
        bind_columns(ROBOT, table("ctrl.turn", "ctrl.pid", "ctrl.push", "ctrl.servo", "ctrl.brake"))
    assert set(several_inputs(ROBOT)) == {"ctrl.turn", "ctrl.pid"}
