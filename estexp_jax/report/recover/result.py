"""A recovery run for Python and Jupyter: iterate over its passes, show its table and figures."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, final

from estexp_jax.recovery.cycle import Job, run_cycle
from estexp_jax.recovery.state import Pass, RunState
from estexp_jax.report.drawing.picture import Picture
from estexp_jax.report.recover.figure import path_figure, progress_figure
from estexp_jax.report.recover.film import Film, film_of
from estexp_jax.report.recover.page import recover_headline, recover_rows
from estexp_jax.report.tables import TextTable

_HEADS = ("pass", "diagnosis", "probability", "predicted (m)", "trial (m)")


@final
class RecoverTable:
    """The passes of a run as a table; in a notebook as HTML."""

    def __init__(self, title: str, rows: list[dict[str, Any]]) -> None:
        self.title, self.rows = title, rows
        self._table = TextTable(title, _HEADS, [_cells(row) for row in rows])

    def __str__(self) -> str:
        return self._table.text()

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

    def plot(self) -> Picture:
        """Distance over the generations, in the shape of the paper's Figure 6."""
        return Picture(progress_figure(self.state, self.job.settings.axis, stands_in=self.job.stands_in))

    def plot_paths(self) -> Picture:
        """The paths of the robot: before the damage, after it, and in the last trial."""
        return Picture(path_figure(self.state, self.job.settings.axis, stands_in=self.job.stands_in))

    def film(self) -> Film | None:
        """The gaits in pictures: before the damage, damaged, recovered.

        Returns:
            The film; None before the damage, and for robots in the real world.

        Raises:
            NoGlError: no renderer works here.
        """
        return film_of(self.job, self.state)

    def _repr_html_(self) -> str:
        return self.table()._repr_html_()
