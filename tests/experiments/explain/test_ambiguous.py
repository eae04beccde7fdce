"""Ambiguities: robots and effects that there are, motions under which they say the same, what counts as settled."""

import numpy as np
import pytest

from estexp_jax.api.simulator import ExplainedSimulator
from estexp_jax.physics.effects.changes import parse_change
from estexp_jax.physics.model.robot import Robot
from experiments.explain.ambiguous.ambiguities import AMBIGUITIES, Ambiguity
from experiments.explain.ambiguous.summary import is_open, summary

TIME = np.arange(400) / 50.0


def _nominal(ambiguity: Ambiguity) -> Robot:
    return Robot.from_string(ambiguity.robot(lambda x: x), "ambiguity.xml")


@pytest.mark.parametrize("ambiguity", AMBIGUITIES, ids=lambda d: d.name)
def test_effects_fit_their_robot_and_motions_its_motors(ambiguity: Ambiguity) -> None:
    robot, rng = _nominal(ambiguity), np.random.default_rng(3)
    changes = [parse_change(effect(s), robot) for effect in ambiguity.effects for s in (0.0, 1.0)]
    assert tuple(dict.fromkeys(c.effect for c in changes)) == ambiguity.names
    first, second = ambiguity.motion(TIME, rng), ambiguity.motion(TIME, rng)
    assert first.shape == (len(TIME), robot.model.nu) and not np.array_equal(first, second)
    limited = robot.model.actuator_ctrllimited.astype(bool)
    assert (np.abs(first).max(axis=0)[limited] <= robot.model.actuator_ctrlrange[limited, 1]).all()


def test_a_tilt_and_a_moved_centre_of_mass_say_the_same_while_the_base_stands_still() -> None:
    ambiguity = next(d for d in AMBIGUITIES if d.name == "tilt or centre of mass")
    robot = _nominal(ambiguity)
    still = ambiguity.motion(TIME, np.random.default_rng(4))
    turned = still + np.array([1.5, 0.0])

    def difference(commands: np.ndarray) -> float:
        tilted, shifted = (
            ExplainedSimulator(robot, (parse_change(text, robot),)).rollout(commands, period=0.02).sensors[100:, 1]
            for text in (f"gravity_tilt angle=0.2 axis={np.pi / 2}", f"com_shift@arm x={0.15 * np.tan(0.2)}")
        )
        return float(np.abs(tilted - shifted).max())

    assert difference(still) < ambiguity.noise < 5.0 * ambiguity.noise < difference(turned)


def test_only_open_cases_count_and_the_right_one_must_stand_alone() -> None:
    base = {"ambiguity": "x", "truth": "a", "random_alone": False, "proposed_alone": True}
    rows = [base | {"before_listed": listed} for listed in ("a b", "a", "b", None, "b a")]
    assert [is_open(row) for row in rows] == [True, False, False, False, True]
    rows[-1]["proposed_alone"] = None
    found = summary(rows)["x"]
    assert (found["n"], found["open"], found["random"]["settled"], found["proposed"]["settled"]) == (5, 2, 0, 1)
    assert found["proposed"]["share"] == 0.5
