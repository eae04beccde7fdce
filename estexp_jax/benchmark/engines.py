"""What `bench` races: every engine on the same robot, population, steps and controllers."""

from __future__ import annotations

import abc
from collections.abc import Callable
from dataclasses import asdict
from functools import cached_property
from typing import Any, final

import jax
import mujoco
import numpy as np

from estexp_jax.benchmark.subject import EFFECTS, BenchmarkRobots
from estexp_jax.physics.effects.changes import encode, stack
from estexp_jax.physics.effects.registry import catalogue
from estexp_jax.physics.engines.c.reference_loops import CSimulator, OpenLoopPool, PooledSimulator, SerialSimulator
from estexp_jax.physics.engines.choice import closed_loop_simulator
from estexp_jax.physics.engines.closed_loop import ClosedLoopSimulator
from estexp_jax.physics.engines.closed_loop_agreement import (
    Agreement,
    closed_loop_agreement,
    commands_of,
    engine_agreement,
    referee_speeds,
)
from estexp_jax.physics.engines.devices import accelerated
from estexp_jax.physics.engines.lanes.closed_loop import LanesClosedLoop

C_ENGINES = ("serial", "serial_open", "rollout", "batch")
JAX_ENGINES = ("mjx", "lanes")
TITLES = {
    "serial": "C, one robot at a time",
    "serial_open": "the same without its controller",
    "rollout": "C on all cores, open loop (mujoco.rollout)",
    "batch": "C on all cores, closed loop (mujoco.batch)",
    "mjx": "MJX, converged",
    "lanes": "lanes",
}
SLOW = 100_000
"""Robot steps in one measurement of an engine that would take long: serial C walks fewer robots, MJX fewer steps."""
_SETS = 16
"""Different robots among those that are compared with the C engine, each of which is compiled anew."""


class Runner(abc.ABC):
    """An engine with its robots."""

    name: str
    robots: int
    steps: int

    @abc.abstractmethod
    def simulate(self, robots: int, steps: int) -> None:
        """Simulate the first robots for some control steps, from the start."""

    @abc.abstractmethod
    def agreement(self) -> Agreement:
        """How far it is from the converged C engine."""

    def facts(self) -> dict[str, Any]:
        """What else there is to say in `bench.json`."""
        return {}


@final
class CRunner(Runner):
    """The C engine, on nominal robots."""

    def __init__(self, name: str, field: BenchmarkRobots) -> None:
        self.name, self._field, race = name, field, field.race
        few = max(1, SLOW // (race.steps * race.substeps))
        self.robots = min(race.population, few) if name.startswith("serial") else race.population
        self.steps = race.steps

    @cached_property
    def _simulator(self) -> CSimulator:
        course = self._field.course
        match self.name:
            case "serial":
                return SerialSimulator(course)
            case "serial_open":
                return SerialSimulator(course, self._field.recorded)
            case "rollout":
                return OpenLoopPool(course, self._field.recorded)
            case _:
                return PooledSimulator(course)

    def simulate(self, robots: int, steps: int) -> None:
        """See `Runner`."""
        self._simulator.rollout(robots, steps)

    def agreement(self) -> Agreement:
        """The model's own solver settings against the converged ones, if all ways to call the engine do the same."""
        field, race = self._field, self._field.race
        robots, steps = min(8, race.population), min(5, race.steps)
        same = np.allclose(
            self._simulator.rollout(robots, steps),
            SerialSimulator(field.course).rollout(robots, steps),
            rtol=0.0,
            atol=1e-9,
        )
        expected = referee_speeds(field.robot, field.face, field.states, race.substeps)
        found = _own_speeds(field) if same else np.full_like(expected, np.nan)
        return engine_agreement(found, expected, race.substeps)


@final
class JaxRunner(Runner):
    """A batch engine, on robots each with its own edits."""

    def __init__(self, name: str, field: BenchmarkRobots, rows: int | None = None) -> None:
        """With walks of at most `rows` control steps; None: those of the race.

        Raises:
            InputError: this engine cannot simulate the robot.
        """
        self.name, self._field, race = name, field, field.race
        step = race.substeps * field.robot.model.opt.timestep
        # Twice the population: all robots are new each time, so that they fill one chunk a core.
        self.simulator: ClosedLoopSimulator = closed_loop_simulator(
            field.robot,
            catalogue(EFFECTS),
            policy=field.policy,
            rows=rows or race.steps,
            control_step=step,
            population=2 * race.population,
            engine=name,
        )
        self.robots, self.steps = race.population, min(race.steps, rows or race.steps)
        if name == "mjx" and not accelerated():
            self.steps = int(np.clip(SLOW // (race.population * race.substeps), 1, self.steps))

    @cached_property
    def _ready(self) -> tuple[Any, Any]:
        field, n = self._field, self._field.race.population
        few = stack([encode(field.robot, self.simulator.catalogue, changes) for changes in field.sets])
        values = {name: array[np.arange(n) % len(field.sets)] for name, array in few.items()}
        start = self.simulator.home(values)
        named = {k: getattr(field.start, k) for k in ("qpos", "qvel", "warmstart", "sensordata")}
        wide = {k: np.broadcast_to(x.astype(np.float32), (n, len(x))) for k, x in named.items()}
        return values, start._replace(**wide)

    def simulate(self, robots: int, steps: int) -> None:
        """See `Runner`."""
        values, start = jax.tree.map(lambda x: x[:robots], self._ready)
        self.simulator.rollout(values, self._field.weights[:robots], start, steps)

    def agreement(self) -> Agreement:
        """The executable that is timed, on robots with edits, against recompiled models."""
        return closed_loop_agreement(self.simulator, self._field.states, [(), *self._field.sets[: _SETS - 1]])

    def facts(self) -> dict[str, Any]:
        """Width of a chunk, work of a step, and whether XLA took the options that make lanes fast."""
        lanes = self.simulator if isinstance(self.simulator, LanesClosedLoop) else None
        return {
            "width": self.simulator.width,
            "flops_per_robot_step": lanes and lanes.flops,
            "fast": lanes and lanes.fast,
        }


def runner(name: str, field: BenchmarkRobots) -> Runner:
    """An engine by name.

    Raises:
        InputError: it cannot simulate the robot.
    """
    return CRunner(name, field) if name in C_ENGINES else JaxRunner(name, field)


Made = Callable[[str, BenchmarkRobots], Runner]
"""Gives an engine by name, as `runner` does."""


def agreement_json(found: Agreement) -> dict[str, Any]:
    """As in `bench.json`."""
    return {**asdict(found), "agrees": found.agrees}


def _own_speeds(field: BenchmarkRobots) -> np.ndarray:
    """Velocities after a control step with the model's own solver settings."""
    model, states, found = field.robot.model, field.states, []
    for k, ctrl in enumerate(commands_of(field.face, states.outputs)):
        data = mujoco.MjData(model)
        data.qpos[:], data.qvel[:], data.qacc_warmstart[:] = states.qpos[k], states.qvel[k], states.warmstart[k]
        data.ctrl[:] = ctrl
        mujoco.mj_step(model, data, field.race.substeps)
        found.append(data.qvel.copy())
    return np.array(found)
