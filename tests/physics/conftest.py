"""What is compiled once for all tests of the physics floor."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from mujoco import mjx

from estexp_jax.physics.changes import Values
from estexp_jax.physics.engines.batching import in_chunks
from estexp_jax.physics.engines.mjx_model import MjxModel, mjx_model
from estexp_jax.physics.engines.mjx_terms import Now
from estexp_jax.physics.engines.choice import walker
from estexp_jax.physics.engines.walking import Walker
from estexp_jax.physics.registry import ALL, PAPER, catalogue
from tests.physics.reference import TRAJECTORY, States
from tests.physics.robots import robot

WIDTH = 128


@dataclass(frozen=True, eq=False)
class Lab:
    """One robot on MJX with every effect: batches of (values, state), all by one executable."""

    on_mjx: MjxModel

    def run(self, values: Values, states: States) -> dict[str, np.ndarray]:
        """Next velocities, configurations after the trajectory, and the constants of the edited models."""
        batch = (values, *(np.asarray(x, np.float32) for x in states[:4]))
        return in_chunks(partial(_run, self), batch, WIDTH)


@partial(jax.jit, static_argnums=0)
def _run(self: Lab, batch: Any) -> dict[str, jax.Array]:
    return jax.vmap(partial(_run_one, self))(*batch)


def _run_one(self: Lab, values: Values, qpos, qvel, ctrl, warmstart) -> dict[str, jax.Array]:  # noqa: ANN001
    on = self.on_mjx
    model = on.edited(on.model, values)
    enable = jnp.ones(on.robot.model.nu)

    def now(data: Any) -> Now:
        return Now(data.qpos, data.qvel, ctrl, enable, model.opt.timestep)

    def step(k, carry):  # noqa: ANN001, ANN202
        data, hidden, first = carry
        does = on.acted(model, values, hidden, now(data))
        data = mjx.step(does.model, data.replace(ctrl=does.ctrl, qfrc_applied=does.force, xfrc_applied=does.pull))
        return data, does.hidden, jnp.where(k == 0, data.qvel, first)

    data = on.data.replace(qpos=qpos, qvel=qvel, ctrl=ctrl, qacc_warmstart=warmstart)
    data, _, first = jax.lax.fori_loop(0, TRAJECTORY, step, (data, on.rested(model, values, now(data)), qvel))
    constants = ("body_subtreemass", "dof_invweight0", "body_invweight0")
    return {"next_qvel": first, "final_qpos": data.qpos} | {name: getattr(model, name) for name in constants}


@pytest.fixture(scope="session")
def lab() -> Callable[[str], Lab]:
    """The lab of a robot, by the robot's name."""
    return cache(lambda name: Lab(mjx_model(robot(name), ALL)))


WALKER_ROWS = 60


@pytest.fixture(scope="session", params=["mjx", "lanes"])
def walkers(request: pytest.FixtureRequest) -> Walker:
    """The quadruped in closed loop with all that the paper breaks, in each engine."""
    effects = catalogue([*PAPER, "neuron_fault", "tied_outputs"])
    return walker(robot("quadruped"), effects, rows=WALKER_ROWS, control_step=0.01, engine=request.param)
