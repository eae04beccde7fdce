"""Robots from what callers hold; their every form is tried in `tests/api/test_what_users_try.py`."""

import mujoco
import pytest

from estexp_jax.errors import InputError
from estexp_jax.physics.model.given import path_or_robot, robot_of
from tests.pendulum import PENDULUM


def test_a_compiled_model_is_taken_with_the_description_that_mujoco_kept_of_it() -> None:
    model = mujoco.MjModel.from_xml_string(PENDULUM)
    robot = robot_of(model)
    assert robot.names("joint") == ("elbow",) and robot.spec.compile().nq == 1
    model.body_mass[1] *= 2.0  # then it is no longer what the description says
    with pytest.raises(InputError, match="has no MJCF any more") as refused:
        robot_of(mujoco.MjModel.from_xml_string(PENDULUM.replace("mass", "name='x' mass")) and model)
    assert "ee.Robot" in refused.value.right


def test_a_path_stays_a_path_for_whoever_reads_by_path() -> None:
    assert path_or_robot("recordings.toml") == "recordings.toml"
    assert path_or_robot(PENDULUM).names("actuator") == ("servo",)  # pyright: ignore[reportAttributeAccessIssue]
