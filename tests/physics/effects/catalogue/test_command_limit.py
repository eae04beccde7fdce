"""A goal led by a profile: it never goes faster than it may, and arrives without overshooting, at any step."""

import jax.numpy as jnp
import numpy as np
import pytest

from estexp_jax.physics.effects.base import NEVER
from estexp_jax.physics.effects.catalogue.command_limit import CommandLimit

V, A, WAY = 1.5, 12.0, 0.9


def led(dt: float, v: float = V, a: float = A, way: float = WAY, seconds: float = 1.2) -> np.ndarray:
    """The goal (steps,) after a step of the command from 0."""
    law, p = CommandLimit(), (jnp.array([v]), jnp.array([a]))
    state, found = law.initial(p, jnp.zeros(1)), []
    for _ in range(round(seconds / dt)):
        _, state = law.act(p, jnp.array([way]), jnp.zeros(1), jnp.asarray(dt), state)
        found.append(float(state[0][0]))
    return np.array(found)


@pytest.mark.parametrize("dt", [0.0005, 0.004, 0.02])
def test_it_keeps_its_limits_and_arrives(dt: float) -> None:
    goal = led(dt)
    speed = np.diff(goal) / dt
    assert speed.max() <= V + 1e-3 and np.abs(np.diff(speed)).max() <= A * dt * 1.01 + 1e-3
    assert goal.max() <= WAY + 1e-3 and goal[-1] == pytest.approx(WAY, abs=1e-5)
    assert speed.max() > 0.99 * V


def test_it_takes_as_long_as_a_trapezoid() -> None:
    dt = 0.001
    arrival = np.argmax(led(dt) > 0.999 * WAY) * dt
    assert arrival == pytest.approx(WAY / V + V / A, abs=0.02)


def test_without_a_limit_of_acceleration_it_is_a_ramp() -> None:
    goal = led(0.002, a=NEVER)
    np.testing.assert_allclose(goal[:200], 0.002 * V * np.arange(1, 201), atol=1e-3)
    assert goal[-1] == pytest.approx(WAY, abs=1e-6)


def test_without_limits_it_is_the_command() -> None:
    np.testing.assert_array_equal(led(0.002, v=NEVER, a=NEVER), np.float32(WAY))
