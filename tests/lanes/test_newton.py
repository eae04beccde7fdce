"""The solver's settings are good enough for all that a quadruped meets, and one iteration is not."""

from collections.abc import Callable

import mujoco
import numpy as np
import pytest

from estexp_jax.physics.effects.changes import neutral, stack
from tests.physics.conftest import COMPARED, Lab
from tests.physics.reference import States, converged
from tests.physics.robots import robot
from tests.recovery.control.controller_twin import N_WEIGHTS, Body, Twin

N_CONTROLLERS, CONTROL_STEPS = 16, 120
REQUIRED = 1e-3
"""m/s (and rad/s), 99th percentile of one-step velocity errors."""


@pytest.fixture(scope="module")
def visited() -> States:
    """States of quadrupeds driven by random networks; some start on their side or back."""
    quadruped = robot("quadruped")
    rng = np.random.default_rng(7)
    model, rows = converged(quadruped.spec.copy().compile()), []
    for k in range(N_CONTROLLERS):
        body, twin = Body(quadruped, model), Twin(rng.uniform(-1.0, 1.0, N_WEIGHTS).round(2))
        start = quadruped.home()
        if k % 4 == 3:
            start[2:7] = [0.3, *rng.normal(size=4)]
            start[3:7] /= np.linalg.norm(start[3:7])
        body.place(start, np.zeros(model.nv), np.zeros(model.nv), np.zeros(4))
        for t in range(CONTROL_STEPS):
            commands = twin.respond(body.readings())
            if t >= 10 and t % 7 == k % 7:
                rows.append(_one(body.data, model, commands))
            body.step(commands)
    return States(*(np.array(column) for column in zip(*rows, strict=True)))


def _one(data: mujoco.MjData, model: mujoco.MjModel, ctrl: np.ndarray) -> tuple:
    now, after = (data.qpos.copy(), data.qvel.copy(), ctrl, data.qacc_warmstart.copy()), mujoco.MjData(model)
    after.qpos[:], after.qvel[:], after.ctrl[:], after.qacc_warmstart[:] = now
    mujoco.mj_step(model, after)
    return *now, after.qvel.copy(), after.qpos.copy(), after.ncon


def test_the_states_hold_all_contact_situations(visited: States) -> None:
    assert len(visited.qpos) >= 200
    assert {0, 1, 2, 3, 4} <= set(visited.contacts.tolist())
    assert visited.contacts.max() >= 5


@pytest.mark.parametrize("engine", ["lanes", pytest.param("mjx", marks=pytest.mark.slow)])
def test_one_step_errors_are_below_a_millimetre_a_second(
    lab: Callable[[str, str], Lab], engine: str, visited: States
) -> None:
    here = lab(engine, "quadruped")
    nominal = stack([neutral(here.on_mjx.robot, COMPARED)] * len(visited.qpos))
    settled = np.abs(here.run(nominal, visited)["next_qvel"] - visited.next_qvel).max(axis=1)
    assert np.quantile(settled, 0.99) < REQUIRED


def test_one_iteration_is_not_enough(visited: States) -> None:
    single = robot("quadruped").spec.copy().compile()
    single.opt.iterations = 1
    data, errors = mujoco.MjData(single), []
    for *now, wanted in zip(*visited[:5], strict=True):
        data.qpos[:], data.qvel[:], data.ctrl[:], data.qacc_warmstart[:] = now
        mujoco.mj_step(single, data)
        errors.append(np.abs(data.qvel - wanted).max())
    assert np.quantile(errors, 0.99) > 100 * REQUIRED, "the bound tells one iteration from enough of them"
