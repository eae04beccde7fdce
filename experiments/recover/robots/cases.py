"""What is done to which robot, and what comes of it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from estexp_jax.package_data import model_path
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.config import Settings, quick_settings
from estexp_jax.recovery.cycle import Job, job_of, run_cycle
from estexp_jax.recovery.simulator import DamageSimulator, damage_simulator
from estexp_jax.recovery.state import RunState
from estexp_jax.runs import enable_compilation_cache, load_checkpoint, save_checkpoint
from experiments.harness.diagnosis_score import amount_error, same_set, text
from experiments.harness.recovery_case import SIZES, Size

DAMAGES = {
    "hexapod": ("part_lost@leg_rm", "motor_weakness@swing_lf loss=0.8"),
    "go1": ("motor_weakness@calf_fl loss=0.8", "sensor_gain@thigh_angle_br gain=0.3"),
}
"""A robot that comes with the package, and what happens to it."""


@dataclass(frozen=True)
class RobotCase:
    """One run.

    Attributes:
        model: the robot.
        damage: as on the command line.
        seed: of the run.
        size: of the search; small is that of `estexp recover --quick`.
    """

    model: str
    damage: str
    seed: int
    size: Size

    @property
    def name(self) -> str:
        """Of its checkpoint."""
        return f"{self.model}-{self.damage.split()[0]}-{self.seed}"

    @property
    def settings(self) -> Settings:
        """Of the run."""
        settings = Settings(situation=None, damage=(self.damage,), seed=self.seed)
        return quick_settings(settings) if self.size == "small" else replace(settings, **SIZES[self.size])


@cache
def _world(model: str, size: Size) -> DamageSimulator:
    enable_compilation_cache()
    return damage_simulator(
        Robot.from_xml(model_path(model)), RobotCase(model, "gravity_tilt angle=0.1", 0, size).settings
    )


def job(case: RobotCase) -> Job:
    """What a run works with."""
    world = _world(case.model, case.size)
    return job_of(world.robot, case.settings, world=world)


def state_of(case: RobotCase, store: Path) -> RunState:
    """The end of a run: kept from an earlier attempt, or run now, from where it was."""
    path, first = store / f"robots-{case.name}.npz", store / f"robots-first-{case.model}-{case.seed}.npz"
    store.mkdir(parents=True, exist_ok=True)
    saved = load_checkpoint(path) or load_checkpoint(first)
    state = RunState() if saved is None else RunState.from_tree(saved)
    phase = state.phase
    for reached in run_cycle(job(case), state):
        state = reached
        if state.phase != phase:  # all damages of a seed begin with the same walk
            save_checkpoint(first if state.phase == "damage" else path, state.to_tree())
            phase = state.phase
    return state


def outcome(case: RobotCase, store: Path) -> dict[str, Any]:
    """A run in a line: distances along x, and what it took for broken."""
    state, made = state_of(case, store), job(case)
    passes = state.passes("x")
    assert state.before is not None
    before, damaged = state.before.distance("x"), state.trials[0].distance("x")
    found = passes[-1].diagnosis
    right = [same_set(made.planted, each.diagnosis) for each in passes]
    in_words = f"{before:.2f} m, damaged {damaged:.2f} m, last trial {passes[-1].hardware:.2f} m; {text(found)}"
    return {
        "model": case.model,
        "damage": case.damage,
        "seed": case.seed,
        "before": before,
        "damaged": damaged,
        **{f"trial_{number}": each.hardware for number, each in enumerate(passes, start=1)},
        "right": right[-1],
        "right_after": right.index(True) + 1 if True in right else None,
        "error": amount_error(made.simulator.robot, made.planted, found),
        "probability": passes[-1].probability,
        "diagnosis": text(found),
        "in_words": in_words,
    }
