"""Commands of actuators with several inputs, in logs that have one column for them."""

from __future__ import annotations

from collections.abc import Mapping

from estexp_jax.physics.model.robot import Robot
from estexp_jax.recordings.columns import Source


def several_inputs(robot: Robot) -> dict[str, tuple[str, ...]]:
    """`ctrl.<actuator>` of each actuator with several inputs, and the columns `.0 .1 ...` of these."""
    counts = zip(robot.names("actuator"), robot.model.actuator_ctrlnum.tolist(), strict=True)
    return {f"ctrl.{name}": tuple(f"ctrl.{name}.{k}" for k in range(n)) for name, n in counts if n > 1}


def with_first_inputs(robot: Robot, sources: Mapping[str, Source]) -> tuple[dict[str, Source], tuple[str, ...]]:
    """Sources in which `ctrl.<actuator>` stands for the first input; the others are zero where nothing gives them.

    Zero is what MuJoCo has there until somebody sets it.

    Args:
        robot: whose actuators they are.
        sources: of our columns.

    Returns:
        The sources, and a note for each actuator that was completed.
    """
    found, notes = dict(sources), []
    for whole, inputs in several_inputs(robot).items():
        if whole not in found:
            continue
        own = found.pop(whole)
        found.setdefault(inputs[0], own)
        absent = [name for name in inputs if name not in found]
        found |= dict.fromkeys(absent, Source(value=0.0))
        notes.append(f"{whole} is taken as {inputs[0]}" + (f"; {', '.join(absent)} as 0" if absent else ""))
    return found, tuple(notes)
