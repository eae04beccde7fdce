"""Robots rendered with any GL; without one, the message that says what to install."""

import numpy as np
import pytest

from estexp_jax.physics.model.robot import Robot
from estexp_jax.report.drawing import gl
from estexp_jax.report.drawing.gl import NoGlError, Shot, render_shots

BALL = "<mujoco><worldbody><body><freejoint/><geom size='.1' rgba='1 0 0 1'/></body></worldbody></mujoco>"


def _shot(one: Robot, qpos: np.ndarray) -> Shot:
    layers = qpos.shape[1]
    return Shot(qpos, np.stack([one.model.geom_rgba] * layers), np.zeros((len(qpos), 3)), 1.0, 90.0, 0.0)


def test_without_a_gl_the_message_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    ball = Robot.from_string(BALL)
    shot = _shot(ball, ball.home()[None, None])
    monkeypatch.setenv("MUJOCO_GL", "off")
    assert gl.backends() == ()
    with pytest.raises(NoGlError, match="MUJOCO_GL forbids it.*libosmesa6"):
        render_shots(ball.model, [shot], width=8, height=8)
    monkeypatch.setenv("MUJOCO_GL", "nonsense")
    with pytest.raises(NoGlError, match="nonsense: .*invalid value for environment variable MUJOCO_GL"):
        render_shots(ball.model, [shot], width=8, height=8)


def test_robots_are_where_they_should_be(renderer: None) -> None:
    ball = Robot.from_string(BALL)
    qpos = np.tile(ball.home(), (2, 2, 1))
    qpos[:, 1, :3] = [[0.3, 0, 0], [0.3, 0, 0.3]]  # the second robot: to the right, then up
    (pictures,) = render_shots(ball.model, [_shot(ball, qpos)], width=60, height=60)
    red = pictures[..., 0].astype(int) > 60
    assert red[:, 28:32, 28:32].all()  # the first one stays in the middle
    assert red[0, 25:35, 50:58].any() and not red[0, :15, 50:58].any()
    assert red[1, 2:15, 50:58].any() and not red[1, 25:35, 50:58].any()
