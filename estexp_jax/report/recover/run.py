"""A recovery run for Python and Jupyter: go through its passes, look at its table and its figures."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape
from typing import Any, final

from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.config import quick_settings as quick_settings
from estexp_jax.recovery.cycle import Job, job_of
from estexp_jax.recovery.cycle import run_cycle as run_cycle
from estexp_jax.recovery.state import Pass, RunState
from estexp_jax.recovery.target import Target
from estexp_jax.report.drawing.picture import Picture
from estexp_jax.report.recover.figure import path_figure, progress_figure
from estexp_jax.report.recover.film import Film, film_of
from estexp_jax.report.recover.page import recover_headline, table

_HEADS = ("pass", "diagnosis", "probability", "predicted (m)", "trial (m)")


@final
class RecoverTable:
    """A run's passes; prints itself, in a notebook as HTML."""

    def __init__(self, title: str, rows: list[dict[str, Any]]) -> None:
        self.title, self.rows = title, rows

    def __str__(self) -> str:
        cells = [_HEADS, *(self._cells(row, "; ") for row in self.rows)]
        widths = [max(len(row[i]) for row in cells) for i in range(len(_HEADS))]
        lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in cells]
        return "\n".join([self.title, *(line.rstrip() for line in lines)])

    def _repr_html_(self) -> str:
        head = "".join(f"<th>{escape(name)}</th>" for name in _HEADS)
        rows = ("".join(f"<td>{escape(c)}</td>" for c in self._cells(row, "; ")) for row in self.rows)
        body = "".join(f"<tr>{row}</tr>" for row in rows)
        return f"<p>{escape(self.title)}</p><table><tr>{head}</tr>{body}</table>"

    @staticmethod
    def _cells(row: dict[str, Any], between: str) -> tuple[str, ...]:
        diagnosis = between.join(row["diagnosis"]) or "nothing differs"
        return (str(row["number"]), diagnosis, row["probability"], row["simulated"], row["hardware"])


@final
class RecoverRun:
    """A run of the estimation-exploration algorithm. Iterating goes on with it, and yields each pass as it ends.

    Attributes:
        job: what it works with.
        state: where it stands.
    """

    def __init__(self, job: Job) -> None:
        self.job, self.state = job, RunState()

    def __iter__(self) -> Iterator[Pass]:
        axis, told = self.job.settings.axis, 0
        for reached in run_cycle(self.job, self.state):
            self.state = reached
            passes = self.state.passes(axis)
            if len(passes) > told:
                told = len(passes)
                yield passes[-1]

    def finish(self) -> RecoverRun:
        """Go on to the end."""
        for _ in self:
            pass
        return self

    def table(self) -> RecoverTable:
        """What each pass found, and how far the robot came."""
        axis = self.job.settings.axis
        return RecoverTable(recover_headline(self.state, axis, self.job.stands_in), table(self.state, axis))

    def plot(self) -> Picture:
        """Distance over the generations, in the shape of the paper's Figure 6."""
        return Picture(progress_figure(self.state, self.job.settings.axis, stands_in=self.job.stands_in))

    def plot_paths(self) -> Picture:
        """The ways it went: before the damage, after it, and in the last trial."""
        return Picture(path_figure(self.state, self.job.settings.axis, stands_in=self.job.stands_in))

    def film(self) -> Film | None:
        """How it walks: before the damage, damaged, recovered; None before the damage, and of robots in the world.

        Raises:
            NoGlError: nothing here can draw.
        """
        return film_of(self.job, self.state)

    def _repr_html_(self) -> str:
        return self.table()._repr_html_()


def recover_run(robot: Robot, /, *, target: Target | None = None, quick: bool = False, **settings: Any) -> RecoverRun:
    """Begin a run of the estimation-exploration algorithm.

    Args:
        robot: the nominal robot.
        target: the damaged robot in the world, any callable from a `Controller` to a `Trial`; None: a simulated one.
        quick: start from the small settings of `--quick`.
        settings: fields of `Settings`: situation, seed, passes, population, generations, steps, ...

    Raises:
        InputError: the robot, the damage or a setting is not possible.
    """
    chosen = Settings(**settings)
    if quick:
        given = {name: settings[name] for name in settings}
        chosen = Settings(**{**quick_settings(Settings()).to_json(), **given})
    return RecoverRun(job_of(robot, chosen, target))
