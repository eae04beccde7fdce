"""The quadruped and its simulators, one for all runs of a process: compiling takes longer than a small run."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from estexp_jax.package_data import model_path
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.control.trial import Trial
from estexp_jax.recovery.cycle import Job, job_of
from estexp_jax.recovery.simulator import DamageSimulator, damage_simulator
from estexp_jax.recovery.target import RemoteTarget, trial_of_result
from estexp_jax.runs import enable_compilation_cache
from experiments.harness.recovery_case import SIZES, RecoveryCase, Size


@cache
def quadruped() -> Robot:
    """The nominal robot."""
    return Robot.from_xml(model_path("quadruped"))


@cache
def world(size: Size) -> DamageSimulator:
    """The simulator of all runs of a size."""
    enable_compilation_cache()
    return damage_simulator(quadruped(), replace(Settings(), **SIZES[size]))


@cache
def short_world() -> DamageSimulator:
    """For walkers, and for many hypotheses under few trials."""
    enable_compilation_cache()
    return damage_simulator(quadruped(), Settings(population=200, steps=300))


def job(case: RecoveryCase) -> Job:
    """What a run works with."""
    return job_of(quadruped(), case.settings, world=world(case.size))


def trial_of(job: Job, weights: np.ndarray, steps: int, healthy: bool = False) -> Trial:
    """A trial of the simulated robot of a run, damaged or still healthy; it answers at once."""
    target = job.healthy if healthy else job.target
    assert target is not None and not isinstance(target, RemoteTarget), "robots of experiments are simulated"
    controller = job.simulator.controller(weights, steps)
    return trial_of_result(target(controller), controller)
