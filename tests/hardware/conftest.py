"""The quadruped."""

import pytest


@pytest.fixture(scope="session")
def quadruped():
    """The robot that comes with the package."""
    from estexp_jax.package_data import model_path
    from estexp_jax.physics.model.robot import Robot

    return Robot.from_xml(model_path("quadruped"))
