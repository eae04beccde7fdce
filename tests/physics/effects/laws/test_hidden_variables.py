"""Law terms with hidden variables: step by step they come to what the closed form says along a recording."""

import jax.numpy as jnp
import numpy as np
import pytest

from estexp_jax.physics.effects.laws.base import JointLaw, JointTrajectory
from estexp_jax.physics.effects.registry import effect
from tests.physics.effects.laws.joint_states import ASKED, REMEMBERING, M, Q, W, force, joint_state


def test_a_rhythm_goes_by_the_time_since_the_beginning() -> None:
    assert force("law_rhythm", 0.4, 1.5, 0.3, state=(2.2,)) == pytest.approx(
        0.4 * np.sin(3.0 * np.pi * 2.2 + 0.3), rel=1e-4
    )
    law, p = effect("law_rhythm"), tuple(jnp.full(len(Q), x) for x in (0.4, 1.5, 0.3))
    assert isinstance(law, JointLaw)
    _, (after,) = law.act(p, joint_state(), (jnp.full(len(Q), 2.2),))
    assert np.asarray(after) == pytest.approx(2.202)


def test_what_creeps_pushes_back_like_a_spring_and_then_lets_go() -> None:
    law = effect("law_creep")
    assert isinstance(law, JointLaw)
    p, one = (jnp.full(1, 5.0), jnp.full(1, 0.5)), jnp.ones(1)
    state, forces = law.initial(p, one, one), []
    for step in range(1500):
        w = one * (2.0 if step < 50 else 0.0)  # 0.1 rad in 50 ms, then held
        does, state = law.act(p, joint_state()._replace(w=w, dt=1e-3 * one), state)
        forces.append(float(does.force[0]))
    assert forces[49] == pytest.approx(-0.5, rel=0.06)
    assert forces[549] == pytest.approx(forces[49] * np.exp(-1.0), rel=1e-2)


def test_what_thins_resists_less_the_longer_it_moves() -> None:
    assert force("law_thinning", 0.4, 2.0, 1.0, state=(0.0,)) == pytest.approx(-0.4 * W, rel=1e-4, abs=1e-6)
    assert force("law_thinning", 0.4, 2.0, 1.0, state=(1.5,)) == pytest.approx(-0.1 * W, rel=1e-4, abs=1e-6)


def test_a_warm_motor_gives_less() -> None:
    assert force("law_warm_motor", 0.6, 0.3, 0.5, state=(0.0,)) == pytest.approx(0.0 * M, abs=1e-6)
    assert force("law_warm_motor", 0.6, 0.3, 0.5, state=(0.3,)) == pytest.approx(-0.6 * M, rel=1e-4, abs=1e-6)
    assert force("law_warm_motor", 0.6, 0.3, 0.5, state=(0.1,)) == pytest.approx(-0.2 * M, rel=1e-4, abs=1e-6)
    assert force("law_warm_motor", 0.6, 0.3, 0.5, state=(300.0,)) == pytest.approx(-0.6 * M, rel=1e-4, abs=1e-6)


def test_of_a_late_command_a_share_is_missing_wherever_the_joint_is() -> None:
    late = -0.7 * (ASKED - 3.0 * Q - 1.2) * (1.0 + np.exp(-0.002 / 0.05)) / 2.0  # the mean over the step
    assert force("law_late_command", 0.7, 0.05, state=(1.2, 1.0)) == pytest.approx(late, rel=1e-4, abs=1e-5)
    assert force("law_late_command", 0.7, 0.05, state=(0.0, 0.0)) == pytest.approx(0.0 * Q, abs=1e-5), (
        "at the beginning"
    )


def test_bristles_hold_like_a_spring_until_they_slip() -> None:
    law = effect("law_bristles")
    assert isinstance(law, JointLaw)
    way = np.array([0.0, 1e-4, 0.2, 0.4, 0.4 - 1e-4])
    trajectory = JointTrajectory(np.arange(5.0), way, *np.zeros((3, 5)))
    built, _ = law.hidden_along((0.5, 0.01), trajectory)
    assert built[1] == pytest.approx(0.5 * 1e-4 / 0.01, rel=0.01)
    assert built[2:4] == pytest.approx([0.5, 0.5]) and built[3] - built[4] == pytest.approx(0.01, rel=0.02)


@pytest.mark.parametrize("name", REMEMBERING)
def test_what_is_remembered_is_what_the_steps_lead_to(name: str) -> None:
    law = effect(name)
    assert isinstance(law, JointLaw)
    values, steps = REMEMBERING[name], np.arange(40)
    way, asked = 0.05 * (1.0 - np.cos(steps / 5.0)), np.sin(steps / 3.0)
    trajectory = JointTrajectory(0.01 * steps, way, np.sin(steps / 5.0), np.cos(steps / 7.0), asked)
    [told, *_] = law.hidden_along(values, trajectory)
    one, p = jnp.ones(1), tuple(jnp.full(1, x) for x in values)
    state, stepped = law.initial(p, trajectory.q[0] * one, one), []
    for q, w, m, c in zip(*trajectory[1:], strict=True):
        at = joint_state()._replace(
            q=q * one, w=w * one, torque=m * one, dt=0.01 * one, asked=lambda c=c: (c * one, c * one)
        )
        stepped.append(float(state[0][0]))
        _, state = law.act(p, at, state)
    lag = 1 if name == "law_bristles" else 0  # at each step they follow the way of the one before
    np.testing.assert_allclose(told[: len(told) - lag], stepped[lag:], atol=1e-5)
