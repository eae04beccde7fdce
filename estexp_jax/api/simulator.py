"""`load_explained`: the simulator that an explanation gives back."""

from __future__ import annotations

from pathlib import Path

from estexp_jax.api.options.keywords import front_door
from estexp_jax.physics.effects.changes import Change, encode
from estexp_jax.physics.effects.registry import catalogue
from estexp_jax.physics.model.robot import Robot
from estexp_jax.replay.explained_simulator import ExplainedSimulator
from estexp_jax.report.explain.files import EFFECTS_SCHEMA
from estexp_jax.report.read_results import DAMAGE, read_results, unreadable_result


@front_door()
def load_explained(folder: str | Path) -> ExplainedSimulator:
    """The simulator that `estexp explain` left in a folder.

    Raises:
        InputError: the folder holds no explanation, or one that does not fit its model.
    """
    path = Path(folder) / "effects.json"
    kept = read_results(path, EFFECTS_SCHEMA, "a list of effects")
    try:
        robot, finer = Robot.from_xml(Path(folder) / kept["nominal"]), int(kept["finer"])
        changes = tuple(Change.from_json(entry) for entry in kept["changes"])
        if finer < 1:
            raise ValueError(f"finer is {finer}")
        encode(robot, catalogue(dict.fromkeys(change.effect for change in changes)), changes)
    except DAMAGE as error:
        raise unreadable_result(path, error) from None
    return ExplainedSimulator(robot, changes, finer)
