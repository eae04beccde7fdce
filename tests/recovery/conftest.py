"""One small simulator of the quadruped for all tests of the recovery floor."""

import pytest

from estexp_jax.package_data import model_path
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.cycle import Job, planted_changes
from estexp_jax.recovery.simulator import DamageSimulator, damage_simulator
from estexp_jax.recovery.target import SameTarget
from estexp_jax.runs import enable_compilation_cache

SETTINGS = Settings(situation=3, seed=1, passes=2, population=8, generations=2, steps=30, settle_steps=10)


@pytest.fixture(scope="session")
def quadruped() -> Robot:
    return Robot.from_xml(model_path("quadruped"))


@pytest.fixture(scope="session")
def settings() -> Settings:
    return SETTINGS


@pytest.fixture(scope="session")
def world(quadruped: Robot) -> DamageSimulator:
    enable_compilation_cache()
    return damage_simulator(quadruped, SETTINGS)


@pytest.fixture(scope="session")
def job(quadruped: Robot, world: DamageSimulator) -> Job:
    planted = planted_changes(quadruped, SETTINGS)
    return Job(SETTINGS, world, planted, SameTarget(world, planted), SameTarget(world, ()))
