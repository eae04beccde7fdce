"""`randomisation` and `actuator_settings`: what was found, for training controllers in other frameworks."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from estexp_jax.api.options.keywords import front_door
from estexp_jax.discovery.export import EXPLAINED_FILE
from estexp_jax.discovery.findings import told_change
from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.model.robot import Robot
from estexp_jax.replay.actuator_settings import ActuatorSettings, actuator_settings_of
from estexp_jax.replay.randomisation import Interval, Randomisation, randomisation_of
from estexp_jax.report.explain.files import EFFECTS_SCHEMA
from estexp_jax.report.read_results import DAMAGE, read_results, unreadable_result

_FINDINGS_SCHEMA = "estexp.findings/1"


@front_door()
def randomisation(folder: str | Path, *, draws: int = 200, seed: int = 0) -> Randomisation:
    """Ranges for domain randomisation from what `estexp explain` found, and draws of whole models.

    Args:
        folder: the --out of `estexp explain`.
        draws: from which ranges are taken.
        seed: of the draws.

    Raises:
        InputError: the folder holds no explanation, or one that does not fit its model.
    """
    path = Path(folder) / "effects.json"
    kept = read_results(path, EFFECTS_SCHEMA, "a list of effects")
    findings = read_results(Path(folder) / "findings.json", _FINDINGS_SCHEMA, "findings")
    try:
        robot = Robot.from_xml(Path(folder) / kept["nominal"])
        reported = {(entry["effect"], entry["name"]): entry["parameters"] for entry in findings["what"]}
        changes, intervals = list[Change](), dict[tuple[str, str], Interval]()
        for change in map(Change.from_json, kept["changes"]):
            parameters = reported.get((told_change(change).effect, change.name))
            if parameters is not None:
                changes.append(change)
                intervals |= _intervals(change, parameters)
        return randomisation_of(robot, changes, intervals, draws=draws, seed=seed)
    except DAMAGE as error:
        raise unreadable_result(path, error) from None


def _intervals(change: Change, parameters: Mapping[str, Any]) -> dict[tuple[str, str], Interval]:
    """The intervals of a change's parameters; an end that is not known is the value itself."""
    found = dict[tuple[str, str], Interval]()
    for name, p in parameters.items():
        ends = [p["value"] if p[end] is None else p[end] for end in ("low", "high")]
        found[change.place, name] = (float(ends[0]), float(ends[1]))
    return found


@front_door()
def actuator_settings(folder: str | Path) -> tuple[ActuatorSettings, ...]:
    """Delay, gains, effort limit, armature, friction of each motor of `model_explained.xml`, named as in mjlab.

    Raises:
        InputError: the folder holds no such model.
    """
    return actuator_settings_of(Robot.from_xml(Path(folder) / EXPLAINED_FILE))
