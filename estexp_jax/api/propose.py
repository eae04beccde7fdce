"""`search_experiment` from Python and Jupyter."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

import numpy as np

from estexp_jax.api.explain_files import RIVALS_SCHEMA
from estexp_jax.api.results import DAMAGE, read_results, unreadable_result
from estexp_jax.discovery.contest import CompetingModels
from estexp_jax.discovery.fitting import Progress as Step
from estexp_jax.errors import InputError, known
from estexp_jax.experiment_design.propose import ProposeConfig, ProposedExperiment
from estexp_jax.experiment_design.propose import search_experiment as _propose
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.engines.choice import ENGINES
from estexp_jax.physics.model.robot import Robot
from estexp_jax.runs import enable_compilation_cache, forget_programs


@final
@dataclass(frozen=True, eq=False)
class Proposal:
    """What `search_experiment` found; prints itself as a table in a notebook.

    Attributes:
        proposed: everything, with its arrays.
    """

    proposed: ProposedExperiment

    @property
    def time(self) -> np.ndarray:
        """Of each row (rows,) of the commands, s."""
        return self.proposed.time

    @property
    def commands(self) -> np.ndarray:
        """What to record next: (rows, nu), in each actuator's control unit."""
        return self.proposed.commands

    def summary(self) -> str:
        """The rivals, and how far apart the proposed motion brings them."""
        from estexp_jax.report.propose.text import propose_summary

        return propose_summary(self.proposed)

    def table(self) -> Any:
        """The pairs of rivals, one a row: a DataFrame where pandas is present, else a list of dicts."""
        from estexp_jax.report.propose.text import propose_rows

        try:
            from pandas import DataFrame  # pyright: ignore[reportMissingImports] (a guest, not a dependency)
        except ImportError:
            return propose_rows(self.proposed)
        return DataFrame(propose_rows(self.proposed))

    def write(self, out: str | Path, *, force: bool = False) -> Path:
        """Write commands, predictions, advice and report into a folder, as the command does; gives the report's path.

        Raises:
            InputError: the folder holds results and `force` is not set.
        """
        from estexp_jax.api.propose_files import write_proposal
        from estexp_jax.runs import open_run

        return write_proposal(open_run(out, force=force), self.proposed)

    def __repr__(self) -> str:
        return self.summary()

    def _repr_html_(self) -> str:
        from estexp_jax.report.propose.text import propose_table

        return propose_table(self.proposed)


@final
@dataclass(frozen=True, eq=False)
class OpenQuestions:
    """What `explain` left open.

    Attributes:
        robot: the nominal one.
        competing_models: the rivals, at least two.
        finer: part of the model's step that they were fitted at.
    """

    robot: Robot
    competing_models: CompetingModels
    finer: int


def propose(
    folder: str | Path,
    *,
    duration: float = ProposeConfig.duration,
    margin: float = ProposeConfig.margin,
    speed: float = ProposeConfig.speed,
    seed: int = ProposeConfig.seed,
    engine: str = ProposeConfig.engine,
    progress: Callable[[Step], None] | None = None,
) -> Proposal:
    """Find the motion that tells apart what an explanation left open.

    Args:
        folder: where `explain` wrote its results.
        duration: of the motion, s.
        margin: share of each range of command, joint and motor force that it may use.
        speed: how many times as fast as in the recordings joints may move.
        seed: of the search.
        engine: auto, lanes or mjx.
        progress: called with each step of the work.

    Raises:
        InputError: the folder holds no explanation, or one without rivals; a number makes no sense.
    """
    config = propose_config_of(duration, margin, speed, seed, engine)
    return run_proposal(read_open_questions(folder), config, progress or _ignore)


def propose_config_of(duration: float, margin: float, speed: float, seed: int, engine: str) -> ProposeConfig:
    """The configuration of these choices.

    Raises:
        InputError: a number makes no sense, or there is no such engine.
    """
    if engine not in ENGINES:
        raise InputError(f"there is no engine '{engine}'", where="--engine", right=known(ENGINES))
    return ProposeConfig(duration=duration, margin=margin, speed=speed, seed=seed, engine=engine)


def read_open_questions(folder: str | Path) -> OpenQuestions:
    """What the explanation in a folder left open.

    Raises:
        InputError: the folder holds no explanation, or one without rivals.
    """
    path = Path(folder) / "rivals.json"
    kept = read_results(path, RIVALS_SCHEMA, "a list of rivals")
    try:
        contest = CompetingModels.from_json(kept)
        robot, finer = Robot.from_xml(Path(folder) / kept["nominal"]), int(kept["finer"])
    except DAMAGE as error:
        raise unreadable_result(path, error) from None
    _check(contest, robot, path)
    return OpenQuestions(robot, contest, finer)


def _check(contest: CompetingModels, robot: Robot, path: Path) -> None:
    for change in (change for rival in contest.models for change in (*rival.claims, *rival.changes)):
        sites = effect(change.effect).sites(robot)
        if (change.name or "") not in sites:
            raise InputError(f"'{change.effect}' cannot act on '{change.name}'", where=str(path), right=known(sites))
    if contest.commands.shape != (robot.model.nu, 2) or contest.speeds.shape != (robot.model.nv,):
        raise InputError("is of another robot than the model beside it", where=str(path), right="explain again")
    if len(contest.models) < 2:
        right = "nothing is left to tell apart; propose serves explanations that have alternatives"
        raise InputError("the explanation has no rivals", where=str(path), right=right)


def run_proposal(left: OpenQuestions, config: ProposeConfig, report: Callable[[Step], None]) -> Proposal:
    """Search.

    Args:
        left: what is open.
        config: how to search.
        report: called after each step.
    """
    enable_compilation_cache()
    forget_programs()
    steps = _propose(left.robot, left.competing_models, left.finer, config)
    while True:
        try:
            report(next(steps))
        except StopIteration as end:
            return Proposal(end.value)


def _ignore(_: Step) -> None:
    pass
