"""A recovery run for Python and Jupyter: iterate over its passes, show its table and figures."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, final

from estexp_jax.errors import InputError
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.cycle import Job, job_of, run_cycle
from estexp_jax.recovery.reality_gap_target import RealityGapTarget
from estexp_jax.recovery.state import Pass, RunState
from estexp_jax.recovery.target import SameTarget
from estexp_jax.report.drawing.onto import picture_of
from estexp_jax.report.drawing.picture import Picture
from estexp_jax.report.recover.figure import path_figure, progress_figure
from estexp_jax.report.recover.files import write_recovery
from estexp_jax.report.recover.film import Film, film_of
from estexp_jax.report.recover.page import recover_headline, recover_rows
from estexp_jax.report.tables import TextTable
from estexp_jax.runs import ProgressDisplay, open_run

_HEADS = ("pass", "diagnosis", "probability", "predicted (m)", "trial (m)")


@final
class RecoverTable:
    """The passes of a run as a table; in a notebook as HTML."""

    def __init__(self, title: str, rows: list[dict[str, Any]]) -> None:
        self.title, self.rows = title, rows
        self._table = TextTable(title, _HEADS, [_cells(row) for row in rows])

    def __str__(self) -> str:
        return self._table.text()

    def __repr__(self) -> str:
        return str(self)

    def _repr_html_(self) -> str:
        return self._table.html()


def _cells(row: dict[str, Any]) -> tuple[str, ...]:
    diagnosis = "; ".join(row["diagnosis"]) or "nothing differs"
    return (str(row["number"]), diagnosis, row["probability"], row["simulated"], row["hardware"])


@final
class RecoverRun:
    """A run of the estimation-exploration algorithm. Iterating continues it, and yields each pass as it ends.

    Attributes:
        job: robot, targets and settings.
        state: the current state.
    """

    def __init__(self, job: Job) -> None:
        self.job, self.state = job, RunState()

    def __reduce__(self) -> tuple[Any, ...]:
        """Without compiled programs: they are made anew where the run goes on."""
        job, simulated = self.job, isinstance(self.job.target, SameTarget | RealityGapTarget)
        targets = (None, None) if simulated else (job.target, job.healthy)
        return unpickled_run, (job.simulator.robot, job.settings, *targets, self.state)

    def __iter__(self) -> Iterator[Pass]:
        axis, yielded = self.job.settings.axis, 0
        for reached in run_cycle(self.job, self.state):
            self.state = reached
            passes = self.state.passes(axis)
            if len(passes) > yielded:
                yielded = len(passes)
                yield passes[-1]

    def finish(self) -> RecoverRun:
        """Continue to the end."""
        for _ in self:
            pass
        return self

    def table(self) -> RecoverTable:
        """The diagnosis of each pass and the distances."""
        axis = self.job.settings.axis
        return RecoverTable(recover_headline(self.state, axis, self.job.stands_in), recover_rows(self.state, axis))

    def summary(self) -> str:
        """What broke and how it walks, in one sentence or two; before the damage what is known by then."""
        return recover_headline(self.state, self.job.settings.axis, self.job.stands_in)

    def plot(self, ax: Any = None) -> Picture:
        """Distance over the generations, in the shape of the paper's Figure 6.

        Args:
            ax: axes of the caller's, made by matplotlib's `subplots`, in whose place it is drawn.
        """
        axis, stands_in = self.job.settings.axis, self.job.stands_in
        return picture_of(lambda: progress_figure(self.state, axis, stands_in=stands_in), ax)

    def plot_paths(self, ax: Any = None) -> Picture:
        """The paths of the robot: before the damage, after it, and in the last trial."""
        axis, stands_in = self.job.settings.axis, self.job.stands_in
        return picture_of(lambda: path_figure(self.state, axis, stands_in=stands_in), ax)

    def write(self, out: str | Path, *, force: bool = False, pictures: bool = True) -> Path:
        """Write results and report into a folder, as the command does; gives the report's path.

        Args:
            out: the folder.
            force: remove what an earlier run wrote there.
            pictures: show the robots in the report, where something here can draw them.

        Raises:
            InputError: the folder holds results and `force` is not set, or nothing has been run yet.
        """
        if not self.state.trials:
            raise InputError(
                "nothing has been run yet", where="write()", right="first iterate over the run, or finish()"
            )
        job, folder = self.job, open_run(out, force=force)
        choice = job.simulator.closed_loop.choice.engine
        config = {"model": Path(job.simulator.robot.source).name, **job.settings.to_json(), "engine": choice}
        with ProgressDisplay() as progress:
            write_recovery(folder, job, self.state, config, progress, pictures=pictures)
        return folder.path / "report.html"

    def film(self) -> Film | None:
        """The gaits in pictures: before the damage, damaged, recovered.

        Returns:
            The film; None before the damage, and for robots in the real world.

        Raises:
            NoGlError: no renderer works here.
        """
        return film_of(self.job, self.state)

    def __repr__(self) -> str:
        return str(self.table())

    def _repr_html_(self) -> str:
        return self.table()._repr_html_()


def unpickled_run(robot: Robot, settings: Settings, target: Any, healthy: Any, state: RunState) -> RecoverRun:
    """A run that was pickled, which can be continued."""
    run = RecoverRun(job_of(robot, settings, target, healthy=healthy))
    run.state = state
    return run
