"""Robots in the world: any callable, and the simulator itself."""

from dataclasses import replace

import numpy as np

from estexp_jax.physics.effects.changes import Change
from estexp_jax.recovery.control.trial import Controller, Trial
from estexp_jax.recovery.cycle import Job, run_cycle
from estexp_jax.recovery.simulator import DamageSimulator
from estexp_jax.recovery.target import FilmedTarget, SameTarget


def test_any_callable_is_a_target(job: Job) -> None:
    calls: list[int] = []

    def still(controller: Controller) -> Trial:
        hidden, commands = controller.respond(controller.rest(), job.simulator.closed_loop.interface.rest)
        assert hidden.shape == (3,) and commands.shape == (8,)
        calls.append(controller.steps)
        rows = controller.steps
        return Trial(np.arange(rows) * 0.01, np.zeros((rows, 8)), np.zeros((rows, 8)), np.zeros((rows, 3)))

    settings = replace(job.settings, paper=True)
    last = list(run_cycle(replace(job, settings=settings, target=still, healthy=None, planted=())))[-1]
    assert calls == [30, 30, 30]
    assert [trial.distance("x") for trial in last.trials] == [0.0] * 3
    assert last.before is not None and last.before.distance("x") == last.simulated[0]


def test_the_same_target_moves_as_its_trial_says(world: DamageSimulator) -> None:
    target = SameTarget(world, [Change("part_lost", "upper_b", {"lost": 1.0})])
    controller = world.controller(np.random.default_rng(4).uniform(-1.0, 1.0, world.n_weights), 30)
    motion = target.motion(controller, [0, 29])
    assert isinstance(target, FilmedTarget) and motion.shape == (2, world.robot.model.nq)
    np.testing.assert_allclose(motion[:, :3], target(controller).position[[0, 29]], atol=1e-6)
