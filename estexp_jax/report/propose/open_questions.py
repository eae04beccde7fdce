"""What an explanation left open, read back from its folder."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import final

from estexp_jax.discovery.competing_models import CompetingModels
from estexp_jax.errors import InputError, known
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.model.robot import Robot
from estexp_jax.report.explain.files import COMPETING_SCHEMA
from estexp_jax.report.read_results import DAMAGE, read_results, unreadable_result


@final
@dataclass(frozen=True, eq=False)
class OpenQuestions:
    """What `explain` left open.

    Attributes:
        robot: the nominal one.
        competing_models: the competing explanations, at least two.
        finer: part of the model's step that they were fitted at.
    """

    robot: Robot
    competing_models: CompetingModels
    finer: int


def read_open_questions(folder: str | Path) -> OpenQuestions:
    """What the explanation in a folder left open.

    Raises:
        InputError: the folder holds no explanation, or one without rivals.
    """
    path = Path(folder) / "rivals.json"
    kept = read_results(path, COMPETING_SCHEMA, "a list of rivals")
    try:
        models = CompetingModels.from_json(kept)
        robot, finer = Robot.from_xml(Path(folder) / kept["nominal"]), int(kept["finer"])
    except DAMAGE as error:
        raise unreadable_result(path, error) from None
    _check(models, robot, path)
    return OpenQuestions(robot, models, finer)


def _check(models: CompetingModels, robot: Robot, path: Path) -> None:
    for change in (change for each in models.models for change in (*each.claims, *each.changes)):
        sites = effect(change.effect).sites(robot)
        if (change.name or "") not in sites:
            raise InputError(f"'{change.effect}' cannot act on '{change.name}'", where=str(path), right=known(sites))
    if models.commands.shape != (robot.model.nu, 2) or models.speeds.shape != (robot.model.nv,):
        raise InputError("is of another robot than the model beside it", where=str(path), right="explain again")
    if len(models.models) < 2:
        right = "nothing is left to tell apart; propose serves explanations that have alternatives"
        raise InputError("the explanation has no rivals", where=str(path), right=right)
