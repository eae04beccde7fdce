"""Closed loops of each engine against the same loop in numpy over the C engine; batches, failures, compilations."""

from collections.abc import Sequence
from typing import Any

import jax
import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.physics.effects.base import Edit
from estexp_jax.physics.effects.changes import Change, Values, encode, neutral, parse_change, stack
from estexp_jax.physics.effects.registry import catalogue, effect, paper
from estexp_jax.physics.engines.choice import closed_loop_simulator
from estexp_jax.physics.engines.closed_loop import BodyState, ClosedLoopSimulator, ReadingOverride, replace_readings
from estexp_jax.physics.engines.mjx.model import mjx_model
from estexp_jax.recovery.control.network import RecurrentPolicy
from estexp_jax.runs import count_compilations
from tests.physics.conftest import WALKER_ROWS
from tests.physics.reference import recompiled
from tests.physics.robots import MUTE, robot
from tests.recovery.control.controller_twin import N_WEIGHTS, Body, Twin

STEPS, SETTLING, N_NETWORKS = 30, 50, 8

DAMAGE: dict[str, tuple[str, ...]] = {
    "healthy": (),
    "lower leg lost": ("part_lost@lower_f",),
    "whole leg lost": ("part_lost@upper_r",),
    "sensors fail": ("sensor_gain@angle_l gain=0.2", "sensor_gain@touch_b gain=0.5"),
    "neuron": ("neuron_fault@hidden_1 gain=0.5",),
    "tied": ("tied_outputs@knee_f with=hip_b",),
    "edits": ("body_mass@upper_b dm=0.25", "motor_weakness@hip_l loss=0.5", "joint_jam@knee_r f=0.5"),
    "tilt and loss": ("gravity_tilt angle=0.2", "part_lost@lower_b", "neuron_fault@hidden_0 gain=0"),
}


def _networks(n: int, seed: int = 3) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-1.0, 1.0, (n, N_WEIGHTS)).round(2).astype(np.float32)


def _values(walkers: ClosedLoopSimulator, changes: Sequence[Change], n: int) -> Values:
    return stack([encode(walkers.robot, walkers.catalogue, changes)] * n)


@pytest.fixture(scope="module")
def settled(walkers: ClosedLoopSimulator) -> dict[str, BodyState]:
    """Each damaged robot at rest, one state a damage; settled in one batch."""
    sets = [_changes(texts) for texts in DAMAGE.values()]
    values = stack([encode(walkers.robot, walkers.catalogue, changes) for changes in sets])
    batch = walkers.settle(values, SETTLING)
    return {name: jax.tree.map(lambda x, i=i: x[i], batch) for i, name in enumerate(DAMAGE)}


def _changes(texts: Sequence[str]) -> list[Change]:
    return [parse_change(text, robot("quadruped")) for text in texts]


def _twin(weights: np.ndarray, changes: Sequence[Change]) -> Twin:
    twin, names = Twin(weights.astype(float)), robot("quadruped").names
    for change in changes:
        match change.effect:
            case "neuron_fault":
                twin.neuron_gain[int((change.name or "")[-1])] = change.parameters["gain"]
            case "tied_outputs":
                twin.tied[names("actuator").index(change.name or "")] = int(change.parameters["with"]) - 1
            case "sensor_gain":
                twin.sensor_gain[names("sensor").index(change.name or "")] = change.parameters["gain"]
    return twin


def _loop(start: BodyState, weights: np.ndarray, changes: Sequence[Change]) -> dict[str, np.ndarray]:
    quadruped = robot("quadruped")
    edits = [c for c in changes if isinstance(effect(c.effect), Edit)]
    body, twin = Body(quadruped, recompiled(quadruped, edits)), _twin(weights, changes)
    body.place(start.qpos, start.qvel, start.warmstart, start.sensordata[:4])
    readings, commands, position = [], [], []
    for _ in range(STEPS):
        readings.append(body.readings() * twin.sensor_gain)
        commands.append(twin.respond(readings[-1]))
        position.append(body.data.qpos[:3].copy())
        body.step(commands[-1])
    return {"readings": np.array(readings), "commands": np.array(commands), "position": np.array(position)}


@pytest.mark.parametrize("damage", DAMAGE)
def test_it_walks_as_a_plain_loop_over_the_c_engine(walkers: ClosedLoopSimulator, settled, damage: str) -> None:
    changes, weights = _changes(DAMAGE[damage]), _networks(N_NETWORKS)
    initial = jax.tree.map(lambda x: np.repeat(x[None], N_NETWORKS, axis=0), settled[damage])
    rollout = walkers.rollout(_values(walkers, changes, N_NETWORKS), weights, initial, STEPS)
    assert not rollout.failed.any()
    agreed = 0
    for i in range(N_NETWORKS):
        wanted = _loop(settled[damage], weights[i], changes)
        np.testing.assert_allclose(rollout.readings[i, 0], wanted["readings"][0], atol=1e-6)
        np.testing.assert_allclose(rollout.commands[i, 0], wanted["commands"][0], atol=1e-5)
        errors = [np.abs(getattr(rollout, k)[i] - wanted[k]).max() for k in ("readings", "commands", "position")]
        agreed += max(errors) < 2e-3
    # A foot that just so touches may do so a step later in single precision; then the two walks part for good.
    assert agreed >= 0.75 * N_NETWORKS


def test_a_walk_holds_what_its_first_and_last_states_say(walkers: ClosedLoopSimulator, settled) -> None:
    initial = jax.tree.map(lambda x: x[None], settled["healthy"])
    rollout = walkers.rollout(_values(walkers, (), 1), _networks(1), initial, STEPS)
    assert rollout.readings.shape == (1, STEPS, 8) and rollout.commands.shape == (1, STEPS, 8)
    np.testing.assert_array_equal(rollout.position[0, 0], initial.qpos[0, :3])
    np.testing.assert_array_equal(rollout.readings[0, 0, 4:], initial.qpos[0, [8, 10, 12, 14]])
    half = walkers.rollout(_values(walkers, (), 1), _networks(1), initial, STEPS // 2)
    np.testing.assert_array_equal(half.readings, rollout.readings[:, : STEPS // 2])
    np.testing.assert_array_equal(half.final.qpos[0, :3], rollout.position[0, STEPS // 2])


def test_it_settles_on_its_feet_at_rest(walkers: ClosedLoopSimulator, settled) -> None:
    healthy = settled["healthy"]
    assert np.abs(healthy.qvel).max() < 0.02
    assert healthy.qpos[2] == pytest.approx(0.18, abs=0.02)
    assert np.all(healthy.sensordata[:4] > 0.0)
    lost = settled["lower leg lost"]
    np.testing.assert_allclose(lost.qpos[8], 0.0, atol=1e-6)  # nothing moves a joint that is no longer there
    assert lost.sensordata[0] == 0.0


def test_population_size_changes_nothing(walkers: ClosedLoopSimulator) -> None:
    weights, changes = _networks(51), _changes(("motor_weakness@hip_f loss=0.4",))
    found = {}
    for n in (7, 50, 51):
        values = _values(walkers, changes, n)
        start = walkers.settle(values, 20)
        assert start.qpos.shape[0] == n
        found[n] = walkers.rollout(values, weights[:n], start, STEPS)
        assert found[n].failed.shape == (n,)
    for n in (7, 50):
        np.testing.assert_array_equal(found[n].readings[0], found[51].readings[0])
        np.testing.assert_array_equal(found[n].final.qpos[0], found[51].final.qpos[0])
    alone = walkers.rollout(
        _values(walkers, changes, 1), weights[50:], jax.tree.map(lambda x: x[:1], walkers.settle(values, 20)), STEPS
    )
    np.testing.assert_array_equal(alone.readings[0], found[51].readings[50])


def test_settling_does_not_depend_on_the_chunk(walkers: ClosedLoopSimulator) -> None:
    changes = [(), _changes(("part_lost@lower_f",)), _changes(("gravity_tilt angle=0.3",))]
    values = [encode(walkers.robot, walkers.catalogue, c) for c in changes]
    mixed = walkers.settle(stack([values[i % 3] for i in range(60)]), 20)
    for i in (0, 1, 2):
        alone = walkers.settle(stack([values[i]]), 20)
        for k in (i, 57 + i):
            np.testing.assert_allclose(mixed.qpos[k], alone.qpos[0], atol=1e-5)


def test_a_robot_that_blows_up_is_marked_and_harms_no_neighbour(walkers: ClosedLoopSimulator) -> None:
    n, bad = 9, 4
    weights, values = _networks(n), _values(walkers, (), n)
    start = walkers.settle(values, 20)
    well = walkers.rollout(values, weights, start, STEPS)
    ill = {k: v.copy() for k, v in values.items()}
    ill["motor_weakness"][bad] = -1e12
    rollout = walkers.rollout(ill, weights, start, STEPS)
    others = np.arange(n) != bad
    np.testing.assert_array_equal(rollout.failed, ~others)
    for name in ("readings", "commands", "position"):
        np.testing.assert_array_equal(getattr(rollout, name)[others], getattr(well, name)[others])
        assert np.isfinite(getattr(rollout, name)[others]).all()
    assert np.isfinite(rollout.final.qpos[others]).all() and not np.isfinite(rollout.final.qpos[bad]).all()


@pytest.mark.parametrize("engine", ["mjx", "lanes"])
def test_one_compilation_serves_settling_and_walks_of_any_length_and_size(engine: str) -> None:
    effects = catalogue(["body_mass", "motor_weakness", "joint_jam"])
    weights = np.zeros((200, 3 * 3 + 9 + 2 * 4), np.float32)
    mjx_model(robot("cartpole"), effects)  # compiles what putting a model takes
    with count_compilations() as found:
        here = closed_loop_simulator(
            robot("cartpole"),
            effects,
            policy=RecurrentPolicy(),
            rows=12,
            control_step=0.01,
            population=4,
            engine=engine,
        )
        counts = []
        for n, steps in ((200, 12), (3, 5), (4, 1)):
            values = stack([neutral(here.robot, here.catalogue)] * n)
            start = here.settle(values, 10)
            rollout = here.rollout(values, weights[:n], start, steps)
            assert rollout.readings.shape == (n, steps, 2)
            counts.append(found.count)
    assert counts[0] <= 2 and counts[2] == counts[0]  # lanes: the edits, and the walk


def test_what_it_refuses(walkers: ClosedLoopSimulator) -> None:
    values = _values(walkers, (), 1)
    for steps in (0, WALKER_ROWS + 1):
        with pytest.raises(ValueError, match=str(WALKER_ROWS)):
            walkers.settle(values, steps)
    short: Any = {"policy": RecurrentPolicy(), "rows": 5, "control_step": 0.01}
    with pytest.raises(ValueError, match="command_delay"):
        closed_loop_simulator(robot("quadruped"), catalogue([*(e.name for e in paper()), "command_delay"]), **short)
    with pytest.raises(InputError, match=MUTE):
        closed_loop_simulator(robot(MUTE), paper(), **short)


def test_networks_that_hear_their_own_readings_walk_as_before(walkers: ClosedLoopSimulator) -> None:
    weights = _networks(3)
    values = _values(walkers, (), 3)
    start = walkers.settle(values, SETTLING)
    closed = walkers.rollout(values, weights, start, STEPS)
    again = walkers.rollout(values, weights, start, STEPS, override=replace_readings(closed.readings))
    assert np.array_equal(again.readings, closed.readings)
    assert np.array_equal(again.commands, closed.commands)


def test_networks_that_hear_recorded_readings_ignore_the_bodys_own(walkers: ClosedLoopSimulator) -> None:
    weights = _networks(2)
    healthy, damaged = (_values(walkers, c, 2) for c in ((), _changes(DAMAGE["whole leg lost"])))
    found = walkers.rollout(healthy, weights, walkers.settle(healthy, SETTLING), STEPS)
    replayed = walkers.rollout(
        damaged, weights, walkers.settle(damaged, SETTLING), STEPS, override=replace_readings(found.readings)
    )
    assert np.array_equal(replayed.commands, found.commands)
    assert not np.array_equal(replayed.readings, found.readings)


def test_networks_hear_noise_that_the_readings_do_not_show(walkers: ClosedLoopSimulator) -> None:
    weights, values = _networks(2), _values(walkers, (), 2)
    start, random = walkers.settle(values, SETTLING), np.random.default_rng(4)
    shape = (2, STEPS, walkers.interface.n_inputs)
    noise = ReadingOverride(np.where(random.random(shape) < 0.1, -1.0, 1.0), 0.02 * random.standard_normal(shape))
    noisy = walkers.rollout(values, weights, start, STEPS, override=noise)
    assert not np.array_equal(noisy.commands, walkers.rollout(values, weights, start, STEPS).commands)
    given = noise.factor * noisy.readings + noise.added
    replayed = walkers.rollout(values, weights, start, STEPS, override=replace_readings(given))
    assert np.allclose(replayed.commands[:, 0], noisy.commands[:, 0], atol=1e-6)
    assert np.allclose(noisy.readings[:, 0], replayed.readings[:, 0])
