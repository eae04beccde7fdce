"""A run whose every diagnosis is the true damage: the most that a diagnosis can be worth."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from estexp_jax.recovery.cycle import Job, run_cycle
from estexp_jax.recovery.state import RunState


def with_true_damage(job: Job, state: RunState) -> Iterator[RunState]:
    """As `cycle.run_cycle`, with the same random numbers, explorations and trials.

    Args:
        job: what it works with; its `planted` is every diagnosis.
        state: to go on from.
    """
    while state.phase != "done":
        if state.phase == "estimation":
            state = _known(job, state)
            yield state
        for reached in run_cycle(job, state):
            state = reached
            yield state
            if state.phase == "estimation":
                break


def _known(job: Job, state: RunState) -> RunState:
    """The state after an estimation that knows the damage."""
    return replace(
        state,
        phase="exploration",
        diagnoses=(*state.diagnoses, job.planted),
        residuals=(*state.residuals, 0.0),
        probabilities=(*state.probabilities, 1.0),
        alternatives=(*state.alternatives, ()),
        alarms=(*state.alarms, False),
        seeds=(*state.seeds, None),
    )
