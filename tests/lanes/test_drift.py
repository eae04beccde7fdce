"""How far lanes in single precision drift from the C engine over 1000 steps, beside what rounding alone does to C.

Prints the table of experiments/speed/README.md: pytest -m slow -s tests/physics/engines/test_lanes_drift.py
"""

import mujoco
import numpy as np
import pytest

from estexp_jax.physics.effects.changes import encode, stack
from estexp_jax.physics.effects.registry import catalogue
from estexp_jax.physics.engines.choice import closed_loop_simulator
from estexp_jax.physics.engines.closed_loop import BodyState, ClosedLoopSimulator, Rollout
from estexp_jax.physics.model.travel import root_position_map
from estexp_jax.recovery.control.network import RecurrentPolicy
from tests.physics.robots import robot

N, STEPS = 32, (1, 10, 100, 1000)
SETTLE = 200
ROUNDING = 2.0**-24
"""Largest relative error of a number rounded to single precision."""


def walked(name: str) -> tuple[ClosedLoopSimulator, BodyState, Rollout]:
    """Robots with random controllers, one physics step a control step."""
    one = robot(name)
    simulator = closed_loop_simulator(
        one,
        catalogue(["body_mass"]),
        policy=RecurrentPolicy(),
        rows=STEPS[-1] + 1,
        control_step=one.model.opt.timestep,
        population=2 * N,
        engine="lanes",
    )
    values = stack([encode(one, simulator.catalogue, ())] * N)
    start = simulator.settle(values, SETTLE)
    weights = np.random.default_rng(7).uniform(-1.0, 1.0, (N, simulator.n_weights))
    return simulator, start, simulator.rollout(values, weights, start, STEPS[-1] + 1)


def in_c(simulator: ClosedLoopSimulator, start: BodyState, commands: np.ndarray, scale: float) -> np.ndarray:
    """Where the roots are (N, rows, 3) under the same commands in the C engine, from `scale` times the start."""
    model, (matrix, offset) = simulator.robot.model, root_position_map(simulator.robot)
    places = []
    for i in range(N):
        data, rows = mujoco.MjData(model), []
        data.qpos[:], data.qvel[:] = (scale * x[i].astype(float) for x in (start.qpos, start.qvel))
        data.qacc_warmstart[:] = start.warmstart[i]
        for row in commands[i]:
            rows.append(matrix @ data.qpos + offset)
            data.ctrl[:] = row
            mujoco.mj_step(model, data)
        places.append(rows)
    return np.array(places)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["cartpole", "quadruped"])
def test_lanes_drift_no_more_than_rounding_makes_c_drift(name: str) -> None:
    simulator, start, rollout = walked(name)
    exact, moved = (in_c(simulator, start, rollout.commands, scale) for scale in (1.0, 1.0 + ROUNDING))
    at = list(STEPS)
    distances, own = (np.linalg.norm(x - exact, axis=-1)[:, at] for x in (rollout.position, moved))
    went = np.linalg.norm(exact - exact[:, :1], axis=-1)[:, at]
    for k, step in enumerate(at):
        cells = [f"{np.quantile(x[:, k], q):.0e}" for x in (distances, own) for q in (0.5, 0.9)]
        print(f"| {name} | {step} | {np.median(went[:, k]):.2g} | {' | '.join(cells)} |")
    assert np.median(distances[:, 1]) < 1e-5
    assert np.median(distances[:, -1]) < max(10.0 * np.median(own[:, -1]), 1e-3)
