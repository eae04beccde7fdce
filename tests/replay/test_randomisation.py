"""Draws of what was found are models of one structure, which MuJoCo steps as a batch, and MJX as far as it can."""

import jax
import mujoco
import numpy as np
import pytest
from mujoco import mjx

from estexp_jax.physics.effects.changes import Change
from estexp_jax.replay.randomisation import Randomisation, randomisation_of
from tests.physics.exported import robot_of

batches = pytest.importorskip("mujoco.batch")  # before MuJoCo 4 there is none

FOUND = (
    Change("command_delay", "lift", {"delay": 0.02}),
    Change("coulomb_friction", "elbow", {"T": 0.2}),
    Change("body_mass", "lower", {"dm": 0.05}),
    Change("dead_band", "bend", {"half_width": 0.05}),
)
INTERVALS = {
    ("command_delay@lift", "delay"): (0.018, 0.023),
    ("coulomb_friction@elbow", "T"): (0.15, 0.22),
    ("body_mass@lower", "dm"): (0.04, 0.06),
    ("dead_band@bend", "half_width"): (0.04, 0.06),
}


@pytest.fixture(scope="module")
def posterior() -> Randomisation:
    return randomisation_of(robot_of("servos"), FOUND, INTERVALS, draws=200, seed=0)


def test_ranges_are_those_of_the_intervals(posterior):
    assert [c.effect for c in posterior.changes] == [c.effect for c in FOUND[:3]], "MuJoCo has no dead band"
    found = {(r.field, r.name): r for r in posterior.ranges}
    delay, friction = found["actuator_delay", "lift"], found["dof_frictionloss", "elbow"]
    assert (delay.low, delay.value, delay.high) == pytest.approx((0.018, 0.02, 0.023), abs=6e-4)
    assert (friction.low, friction.value, friction.high) == pytest.approx((0.15, 0.2, 0.22), abs=0.012)
    assert {r.field for r in posterior.ranges} >= {"body_mass", "body_inertia"}
    assert "dof_frictionloss[1] elbow: 0.2" in repr(posterior)


def test_a_hundred_draws_step_in_mujocos_batch(posterior):
    fields = posterior.fields(100, seed=1)
    batch = batches.Batch(posterior.model, 100, nthread=1)
    for name, values in fields.items():
        batch.expand(name)[...] = values
    batch.bind("ctrl")[:] = [0.6, -0.4]
    for _ in range(60):
        batch.step()
    moved = np.array(batch.bind("qpos"))
    assert np.isfinite(moved).all() and moved.std(axis=0).min() > 1e-4
    alone = _stepped_alone(posterior, {name: values[7] for name, values in fields.items()})
    np.testing.assert_allclose(moved[7], alone, atol=1e-6)


def _stepped_alone(posterior: Randomisation, fields: dict[str, np.ndarray]) -> np.ndarray:
    model = posterior.model
    own = {name: np.array(getattr(model, name)) for name in fields}
    try:
        for name, values in fields.items():
            getattr(model, name)[...] = values
        data = mujoco.MjData(model)
        data.ctrl[:] = [0.6, -0.4]
        for _ in range(60):
            mujoco.mj_step(model, data)
        return data.qpos.copy()
    finally:
        for name, values in own.items():
            getattr(model, name)[...] = values


@pytest.mark.slow
def test_a_hundred_draws_step_in_mjx_where_it_has_their_elements():
    found, intervals = FOUND[1:3], {k: v for k, v in INTERVALS.items() if "delay" not in k[0]}
    posterior = randomisation_of(robot_of("servos"), found, intervals, draws=20, seed=0)
    nominal = mjx.put_model(posterior.model)
    drawn = posterior.fields(100, seed=1)
    fields = {k: v for k, v in drawn.items() if hasattr(nominal, k)}
    models = nominal.replace(**{k: jax.numpy.asarray(v) for k, v in fields.items()})
    axes = jax.tree.map(lambda _: None, nominal).replace(**dict.fromkeys(fields, 0))
    data = mjx.make_data(posterior.model).replace(ctrl=jax.numpy.array([0.1, -0.1]))  # MJX brakes motors at limits
    after = jax.vmap(mjx.step, in_axes=(axes, None))(models, data)
    assert after.qvel.shape == (100, 2) and np.asarray(after.qvel).std(axis=0).max() > 1e-5
    batch = batches.Batch(posterior.model, 100, nthread=1)
    for name, values in drawn.items():
        batch.expand(name)[...] = values
    batch.bind("ctrl")[:] = [0.1, -0.1]
    moved = batch.bind("qvel")
    batch.step()
    np.testing.assert_allclose(after.qvel, moved, atol=2e-4)
