"""Robots in the world: any callable, and the simulator itself."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.physics.effects.changes import Change
from estexp_jax.recovery.control.trial import Controller, Trial
from estexp_jax.recovery.cycle import Job, run_cycle
from estexp_jax.recovery.simulator import DamageSimulator
from estexp_jax.recovery.target import FilmedTarget, SameTarget, trial_of_result


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


def _controller(world: DamageSimulator) -> Controller:
    return world.controller(np.random.default_rng(4).uniform(-1.0, 1.0, world.n_weights), 30)


def test_a_target_may_give_a_dict_of_readings_alone(world: DamageSimulator) -> None:
    controller = _controller(world)
    whole = SameTarget(world, [])(controller)
    by_name = {f"sensor.{n}": whole.readings[:, k] for k, n in enumerate(controller.interface.names)}
    for given in ({"readings": whole.readings.tolist()}, by_name):
        found = trial_of_result(given, controller)
        np.testing.assert_allclose(found.readings, whole.readings)
        np.testing.assert_allclose(found.commands, whole.commands, atol=1e-5)
        assert np.isnan(found.distance("x"))
    found = trial_of_result({**by_name, "position": whole.position, "time": whole.time}, controller)
    assert found.distance("x") == pytest.approx(whole.distance("x"))


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (3.0, "it gave float"),
        (None, "it gave NoneType"),
        ({}, "no readings of touch_f"),
        ({"readings": np.zeros((30, 3))}, r"readings are \(30, 3\)"),
        ({"readings": np.full((30, 8), np.nan)}, "readings are not all finite"),
        ({"readings": "walked"}, "it gave something that is no array of numbers"),
        ({"readings": np.zeros((30, 8)), "commands": np.zeros((29, 8))}, r"commands is \(29, 8\)"),
        ({"readings": np.zeros((30, 8)), "position": np.zeros(30)}, r"position is \(30,\)"),
    ],
)
def test_what_is_no_trial_is_refused_with_what_would_be_one(world: DamageSimulator, given: Any, said: str) -> None:
    with pytest.raises(InputError, match=rf"target: {said}"):
        trial_of_result(given, _controller(world))
