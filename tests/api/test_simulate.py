"""`ee.simulate`: the model and the commands in every form, and what is refused."""

from pathlib import Path

import mujoco
import numpy as np
import pandas as pd
import pytest

import estexp_jax as ee
from estexp_jax.errors import InputError
from tests.physics.mixed_actuators import MIXED
from tests.versions import needs_mujoco_4

pytestmark = needs_mujoco_4  # for the model's motors

TIME = 0.01 * np.arange(30)
COLUMNS = ("turn.0", "turn.1", "turn.2", "pid.0", "pid.1", "push", "servo")
COMMANDS = {"time": TIME} | {f"ctrl.{name}": 0.2 * np.sin(9.0 * TIME + k) for k, name in enumerate(COLUMNS)}


def test_a_model_and_commands_in_every_form_give_the_same(tmp_path: Path) -> None:
    path, log = tmp_path / "mixed.xml", tmp_path / "commands.csv"
    path.write_text(MIXED, encoding="utf-8")
    pd.DataFrame(COMMANDS).to_csv(log, index=False)
    wanted = ee.simulate(path, COMMANDS)
    models = (str(path), mujoco.MjSpec.from_string(MIXED), mujoco.MjModel.from_xml_path(str(path)))
    given = [(model, COMMANDS) for model in (*models, ee.Robot.from_xml(path))]
    for model, commands in (*given, (path, pd.DataFrame(COMMANDS)), (path, log)):
        found = ee.simulate(model, commands)
        assert list(found) == list(wanted)
        for name, values in wanted.items():
            np.testing.assert_allclose(found[name], values, atol=1e-12, err_msg=name)
    assert {"time", "sensor.looks.3", "sensor.bends", "qpos.neck.3", "qvel.neck.2", "qpos.wrist"} < set(wanted)


@pytest.mark.parametrize(
    ("commands", "options", "message"),
    [
        ({"time": TIME}, {}, "no column 'ctrl.turn.0'"),
        ({**COMMANDS, "ctrl.brake": TIME}, {}, "'ctrl.brake' names nothing on this robot"),
        ([COMMANDS, COMMANDS], {}, "2 logs"),
        (COMMANDS, {"engine": "lanes"}, "a compiled model cannot be taken to lanes"),
        (COMMANDS, {"engine": "fast"}, "there is no engine 'fast'"),
        (COMMANDS, {"start": {"qpos": [0.0]}}, "qpos is not 6 finite numbers"),
        (COMMANDS, {"start": {"act": [0.0]}}, "has no part 'act'"),
        (COMMANDS, {"start": {"qvel": ["fast"] * 5}}, "qvel is no list of numbers"),
    ],
)
def test_what_does_not_fit_is_refused(commands: object, options: dict[str, object], message: str) -> None:
    model = mujoco.MjModel.from_xml_string(MIXED)
    with pytest.raises(InputError, match=message):
        ee.simulate(model, commands, **options)  # pyright: ignore[reportArgumentType, reportCallIssue]
