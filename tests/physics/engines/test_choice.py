"""What engines do with features of MuJoCo is what the page on engines says."""

import re

import pytest

from estexp_jax.errors import InputError
from estexp_jax.physics.effects.registry import catalogue
from estexp_jax.physics.engines.choice import open_loop_simulator
from estexp_jax.physics.model.robot import Robot
from tests.conftest import ROOT
from tests.physics.engines.features import FEATURES

EFFECTS = catalogue(["body_mass"])
PAGE = (ROOT / "docs" / "engines.md").read_text(encoding="utf-8")
TABLE = {name: said for name, *said in re.findall(r"^\| (.+?) \| (right|refused|differs) \| (right) \|$", PAGE, re.M)}
REFUSED = [name for name, (lanes, _) in TABLE.items() if lanes == "refused"]


def on(engine: str, feature: str) -> float | None:
    robot = Robot.from_string(FEATURES[feature], "robot.xml")
    simulator = open_loop_simulator(robot, EFFECTS, [robot], engine=engine, width=8, block=4)
    return simulator.choice.largest_difference


def test_the_table_has_a_row_for_each_feature() -> None:
    assert list(TABLE) == list(FEATURES)


@pytest.mark.parametrize("feature", FEATURES)
def test_c_is_right(feature: str) -> None:
    assert on("c", feature) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("feature", REFUSED)
def test_lanes_refuse_by_name(feature: str) -> None:
    with pytest.raises(InputError, match=r"(supported by the lanes engine|MJX has no actuator).*use --engine c"):
        on("lanes", feature)


@pytest.mark.slow
@pytest.mark.parametrize("feature", [name for name in TABLE if name not in REFUSED])
def test_lanes_are_right_or_found_out(feature: str) -> None:
    if TABLE[feature][0] == "differs":
        with pytest.raises(InputError, match="the lanes engine, as it runs here, differs from plain MuJoCo"):
            on("lanes", feature)
    else:
        assert (on("lanes", feature) or 0.0) < 1e-3
