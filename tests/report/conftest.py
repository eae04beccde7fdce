"""What tests of several reports need."""

import numpy as np
import pytest


@pytest.fixture(scope="session")
def renderer() -> None:
    """Skips where no renderer works."""
    from estexp_jax.physics.model.robot import Robot
    from estexp_jax.report.drawing.gl import NoGlError, Shot, render_shots

    ball = Robot.from_string("<mujoco><worldbody><body><freejoint/><geom size='.1'/></body></worldbody></mujoco>")
    view = np.zeros((1, 3)), 1.0, 90.0, 0.0
    try:
        render_shots(ball.model, [Shot(ball.home()[None, None], ball.model.geom_rgba[None], *view)], width=8, height=8)
    except NoGlError as error:
        pytest.skip(str(error))
