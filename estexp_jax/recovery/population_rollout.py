"""Simulation of a population of damaged robots in one batch."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from estexp_jax.errors import InputError
from estexp_jax.physics.effects.changes import Change, parse_change
from estexp_jax.physics.engines.closed_loop import Rollout
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.simulator import damage_simulator

Edit = str | Change
"""A change, or its text: "motor_weakness@knee_f loss=0.5"."""


def population_rollout(
    robot: Robot,
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
        robot: the nominal robot.
        edits: the changes of each robot; empty for a healthy one.
        controllers: (robots, n_weights), weights in [-1, 1].
        steps: control steps.
        control_step: s.
        settle_steps: control steps with motors at home before.
        gain: of the neurons' tanh.

    Returns:
        Arrays (robots, steps, ...): raw `readings` (touch as +1/-1), `commands`, the root's `position` in m; and
        `failed` (robots,), where the simulation diverged.

    Raises:
        InputError: the shapes of edits and controllers do not match, or an edit has no place on the robot.
    """
    sets = [[parse_change(e, robot) if isinstance(e, str) else e for e in one] for one in edits]
    settings = Settings(
        situation=None,
        steps=max(steps, settle_steps, 21),
        control_step=control_step,
        settle_steps=settle_steps,
        gain=gain,
        population=max(4, 2 * len(sets)),
    )
    world = damage_simulator(robot, settings, [change for one in sets for change in one])
    weights = np.asarray(controllers, float)
    if weights.shape != (len(sets), world.n_weights) or not sets:
        right = f"one row of {world.n_weights} weights for each of the {len(sets)} robots"
        raise InputError(f"controllers have the shape {weights.shape}", where="rollout", right=right)
    return world.rollout_each(sets, weights, steps)
