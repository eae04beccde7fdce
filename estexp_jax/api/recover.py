"""`recover_run` and `population_rollout` from Python and Jupyter."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from estexp_jax.physics.engines.closed_loop import Rollout
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery import population_rollout as front
from estexp_jax.recovery.target import Target
from estexp_jax.report.recover import run as recover_run
from estexp_jax.report.recover.run import RecoverRun
from estexp_jax.runs import enable_compilation_cache


def recover(robot: Robot, /, *, target: Target | None = None, quick: bool = False, **settings: Any) -> RecoverRun:
    """Recover a robot from damage: iterating over the result runs the algorithm pass by pass.

    Args:
        robot: the nominal robot.
        target: the damaged robot in the world, any callable: controller -> trial; None: a simulated one.
        quick: start from the small settings of `--quick`.
        settings: as of `estexp recover`: situation, damage, seed, passes, population, generations, steps, ...

    Raises:
        InputError: the robot or a setting cannot be used.
    """
    enable_compilation_cache()
    return recover_run.recover_run(robot, target=target, quick=quick, **settings)


def rollout(
    robot: Robot,
    edits: Sequence[Sequence[front.Edit]],
    controllers: np.ndarray,
    steps: int = 1000,
    **settings: Any,
) -> Rollout:
    """Simulate many robots, each with its own damage and controller, in one batch; see `recovery.front.rollout`."""
    enable_compilation_cache()
    return front.population_rollout(robot, edits, controllers, steps, **settings)
