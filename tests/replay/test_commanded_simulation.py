"""Commands replayed through a model are a loop over `mj_step`, readings taken before the row's command acts."""

import mujoco
import numpy as np
import pytest

from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.physics.window import InitialState
from estexp_jax.replay.commanded_simulation import GivenState, simulate_commands
from tests.physics.engines.features import FEATURES

ROWS, STEPS = 40, 3


def commanded(robot: Robot, seed: int = 0) -> Recording:
    model, rng = robot.model, np.random.default_rng(seed)
    time = STEPS * model.opt.timestep * np.arange(ROWS)
    sensor, qpos, qvel = (np.full((ROWS, n), np.nan) for n in (model.nsensordata, model.nq, model.nv))
    ctrl = np.repeat(rng.uniform(-1.0, 1.0, (ROWS // 8, model.nu)), 8, axis=0)
    return Recording("commands", time, ctrl, np.ones((ROWS, model.nactuator)), sensor, qpos, qvel)


def plain(model: mujoco.MjModel, ctrl: np.ndarray, start: InitialState) -> dict[str, np.ndarray]:
    data, found = mujoco.MjData(model), {"sensor": [], "qpos": [], "qvel": []}
    data.qpos[:], data.qvel[:] = start.qpos, start.qvel
    for row in ctrl:
        seen = mujoco.MjData(model)
        mujoco.mj_copyData(seen, model, data)
        mujoco.mj_forward(model, seen)
        for kind, values in (("sensor", seen.sensordata), ("qpos", data.qpos), ("qvel", data.qvel)):
            found[kind].append(values.copy())
        data.ctrl[:] = row
        for _ in range(STEPS):
            mujoco.mj_step(model, data)
    return {kind: np.array(rows) for kind, rows in found.items()}


@pytest.mark.parametrize("feature", FEATURES)
def test_it_is_a_loop_over_mujoco(feature: str) -> None:
    robot = Robot.from_string(FEATURES[feature], feature)
    commands, qvel = commanded(robot), np.linspace(0.4, 1.0, robot.model.nv)
    start = InitialState(robot.home(), qvel)
    found = simulate_commands(robot, commands, start, "auto")
    for kind, wanted in plain(robot.model, commands.ctrl, start).items():
        columns = [values for name, values in found.items() if name.startswith(kind)]
        np.testing.assert_allclose(np.transpose(columns), wanted, atol=1e-9, err_msg=kind)


@pytest.mark.parametrize("start", [{"qpos": [0.3, -0.2]}, ([0.3, -0.2], [0.0, 0.0]), None])
def test_it_starts_where_it_is_told_or_the_first_row_says(start: GivenState | None) -> None:
    robot = Robot.from_string(FEATURES["servos at hinges"])
    commands = commanded(robot)
    if start is None:
        commands.qpos[0] = [0.3, -0.2]
    found = simulate_commands(robot, commands, start, "c")
    assert (found["qpos.shoulder"][0], found["qpos.elbow"][0], found["qvel.elbow"][0]) == (0.3, -0.2, 0.0)
