"""Data files of a recovery run: its record, its generations, its trials."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import IO, Any

import numpy as np

from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.engines.controller_interface import Interface
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.state import RunState

_COLUMNS = ("pass", "phase", "generation", "best", "median", "dominant")


def run_record(
    state: RunState, axis: str, planted: Sequence[Change], config: Mapping[str, Any], *, stands_in: bool = False
) -> dict[str, Any]:
    """The contents of `run.json` without versions; distances in m, forward positive.

    Args:
        state: the run.
        axis: of the distance.
        planted: the true damage.
        config: of the run, with `seed`.
        stands_in: the values before the damage are the simulator's, so the distance before is unknown.
    """
    before = None if state.before is None or stands_in else state.before.distance(axis)
    return {
        "config": dict(config),
        "seed": config["seed"],
        "planted": [change.to_json() for change in planted],
        "distance": {
            "before": before,
            "damaged": state.trials[0].distance(axis) if state.trials else None,
        },
        "passes": [
            {
                "simulated_m": each.simulated,
                "diagnosis": [change.to_json() for change in each.diagnosis],
                "probability": each.probability,
                "rivals": [
                    {"diagnosis": [change.to_json() for change in diagnosis], "probability": p}
                    for diagnosis, p in each.alternatives
                ],
                "alarm": each.alarm,
                "hardware_m": each.hardware,
            }
            for each in state.passes(axis)
        ],
    }


def write_history(stream: IO[bytes], state: RunState) -> None:
    """Write `history.parquet`: one row for each generation."""
    import pyarrow
    import pyarrow.parquet

    columns = list(zip(*state.history, strict=True)) or [[] for _ in _COLUMNS]
    table = pyarrow.table(dict(zip(_COLUMNS, (list(column) for column in columns), strict=True)))
    pyarrow.parquet.write_table(table, stream)


def write_traces(stream: IO[bytes], state: RunState, robot: Robot, interface: Interface) -> None:
    """Write `traces.npz`: the damaged robot's trials; trial 0 is the first after the damage."""
    arrays: dict[str, Any] = {}
    for number, trial in enumerate(state.trials):
        arrays[f"trial_{number}/time"] = trial.time
        for name, column in zip(interface.names, trial.readings.T, strict=True):
            arrays[f"trial_{number}/{name}"] = column
        for name, column in zip(robot.command_columns(), trial.commands.T, strict=True):
            arrays[f"trial_{number}/ctrl/{name}"] = column
    np.savez(stream, **arrays)
