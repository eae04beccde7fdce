"""`rollout`: a population of damaged robots in one batch."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from estexp_jax.api.options.keywords import front_door
from estexp_jax.physics.engines.closed_loop import Rollout
from estexp_jax.physics.model.given import ModelLike, robot_of
from estexp_jax.recovery.population_rollout import Edit, population_rollout
from estexp_jax.runs import enable_compilation_cache


@front_door()
def rollout(
    robot: ModelLike,
    edits: Sequence[Sequence[Edit]],
    controllers: np.ndarray,
    steps: int = 1000,
    *,
    control_step: float = 0.01,
    settle_steps: int = 50,
    gain: float = 3.0,
) -> Rollout:
    """Simulate many robots, each with its own damage and controller, in one batch.

    Args:
        robot: the nominal robot: a path, MJCF text, an MjSpec, an MjModel or a Robot.
        edits: the changes of each robot; empty for a healthy one.
        controllers: (robots, n_weights), weights in [-1, 1].
        steps: control steps.
        control_step: time between two commands, s.
        settle_steps: control steps with all motors at home before.
        gain: of the neurons' tanh.

    Returns:
        Arrays (robots, steps, ...): raw `readings` (touch as +1/-1), `commands`, the root's `position` in m; and
        `failed` (robots,), where the simulation blew up.

    Raises:
        InputError: numbers of edits and controllers or of weights do not fit, or an edit has no place on the robot.
    """
    enable_compilation_cache()
    return population_rollout(
        robot_of(robot), edits, controllers, steps, control_step=control_step, settle_steps=settle_steps, gain=gain
    )
