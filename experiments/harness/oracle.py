"""A run in which every estimation is handed the true damage: the most that knowing it can give."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from estexp_jax.recovery.cycle import Job, run
from estexp_jax.recovery.state import RunState


def told(job: Job, state: RunState) -> Iterator[RunState]:
    """As `cycle.run`, with the same random numbers, explorations and trials.

    Args:
        job: what it works with; its `planted` is what is handed over.
        state: to go on from.
    """
    while state.phase != "done":
        if state.phase == "estimation":
            state = _handed(job, state)
            yield state
        for reached in run(job, state):
            state = reached
            yield state
            if state.phase == "estimation":
                break


def _handed(job: Job, state: RunState) -> RunState:
    """The state after an estimation that knew."""
    return replace(
        state,
        phase="exploration",
        diagnoses=(*state.diagnoses, job.planted),
        residuals=(*state.residuals, 0.0),
        probabilities=(*state.probabilities, 1.0),
        rivals=(*state.rivals, ()),
        alarms=(*state.alarms, False),
        seeds=(*state.seeds, None),
    )
