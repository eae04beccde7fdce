"""The files that `search_experiment` leaves."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from estexp_jax.experiment_design.propose import ProposedExperiment
from estexp_jax.recordings.write import write_csv
from estexp_jax.report.propose.advice import propose_advice
from estexp_jax.report.propose.page import propose_page
from estexp_jax.report.propose.text import column_of
from estexp_jax.runs import RunFolder, write_text


def write_proposal(folder: RunFolder, proposed: ProposedExperiment) -> Path:
    """Write commands, what each explanation predicts, advice and report; gives the report's path."""
    names = proposed.robot.command_columns()
    columns = {f"ctrl.{name}": proposed.commands[:, a] for a, name in enumerate(names)}
    for n, readings in enumerate(proposed.predicted.readings, start=1):
        write_csv(folder.file(f"rivals/{n}.csv"), {"time": proposed.time, **_columns(proposed, readings)})
    write_csv(folder.file("commands.csv"), {"time": proposed.time, **columns})
    write_text(folder.file("advice.md"), propose_advice(proposed))
    report = folder.file("report.html")
    write_text(report, propose_page(proposed))
    return report


def _columns(proposed: ProposedExperiment, readings: np.ndarray) -> dict[str, np.ndarray]:
    """Readings (rows, channels) under the names that recordings have for them."""
    return {
        column_of(proposed.robot, name): readings[:, c] for c, name in enumerate(proposed.competing_models.channels)
    }
