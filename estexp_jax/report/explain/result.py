"""What `explain` found, for Python and Jupyter."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

from estexp_jax.discovery.clock_doubt import clock_lines
from estexp_jax.discovery.diagnosis import Diagnosis, Prediction
from estexp_jax.discovery.law_findings import joint_unit
from estexp_jax.replay.explained_simulator import ExplainedSimulator
from estexp_jax.report.drawing.onto import picture_of
from estexp_jax.report.drawing.picture import Picture
from estexp_jax.report.explain.competing_models import figure_competing_models
from estexp_jax.report.explain.figures import figure_fit, figure_ranking, figure_where
from estexp_jax.report.explain.files import write_explanation
from estexp_jax.report.explain.found import (
    ClaimedEffect,
    ErrorPlace,
    FitErrors,
    claimed_effects,
    error_places,
    fit_errors,
)
from estexp_jax.report.explain.latex import latex
from estexp_jax.report.explain.law_figure import figure_law
from estexp_jax.report.explain.text import explain_rows, explain_summary, explain_table
from estexp_jax.report.tables import data_frame
from estexp_jax.runs import open_run


@final
@dataclass(frozen=True, eq=False)
class ExplainResult:
    """What `explain` found; prints itself as a table in a notebook.

    Attributes:
        diagnosis: everything, with its arrays.
        findings: as in `findings.json`.
    """

    diagnosis: Diagnosis
    findings: Mapping[str, Any]

    def summary(self) -> str:
        """Clocks that do not agree, the verdict, what is missing, and how well unseen recordings are predicted."""
        return "\n".join([*clock_lines(self.diagnosis.case.recordings), explain_summary(self.findings)])

    def table(self) -> Any:
        """The claimed effects, one parameter a row: a DataFrame where pandas is present, else a list of dicts."""
        return data_frame(explain_rows(self.findings))

    @property
    def verdict(self) -> str:
        """`consistent`, `parameters`, `missing_physics` or `unexplained`."""
        return self.findings["verdict"]

    @property
    def what(self) -> tuple[ClaimedEffect, ...]:
        """What is missing or wrong; empty unless the verdict names something."""
        return claimed_effects(self.findings)

    @property
    def where(self) -> tuple[ErrorPlace, ...]:
        """Places of the mismatch, ranked."""
        return error_places(self.findings)

    @property
    def fit(self) -> FitErrors:
        """Errors before and after."""
        return fit_errors(self.findings)

    @property
    def simulator(self) -> ExplainedSimulator:
        """The corrected simulator; as `load_explained` gives it from a folder."""
        return ExplainedSimulator(self.diagnosis.case.robot, self.diagnosis.changes, self.diagnosis.finer)

    def predictions(self) -> tuple[Prediction, ...]:
        """Each recording beside what the nominal and the explained simulator predict of it, in windows."""
        return self.diagnosis.predictions

    def plot_where(self, ax: Any = None) -> Picture:
        """Where the error is.

        Args:
            ax: axes of the caller's, made by matplotlib's `subplots`, in whose place it is drawn; so in all of these.
        """
        return picture_of(lambda: figure_where(self.diagnosis), ax)

    def plot_fit(self, ax: Any = None, *, reading: str | None = None, recording: str | None = None) -> Picture:
        """A recording, before and after.

        Args:
            ax: axes of the caller's, as for `plot_where`.
            reading: name of the sensor to show, such as `knee_angle`; None: the one with the largest error.
            recording: file name of the recording, such as `c.csv`; None: a test recording.

        Raises:
            InputError: there is none of that name, or it has no sample; the message lists what there is.
        """
        return picture_of(lambda: figure_fit(self.diagnosis, reading, recording), ax)

    def plot_rivals(self, ax: Any = None) -> Picture:
        """Test and training errors of the nominal simulator, the competing models and the explanation."""
        return picture_of(lambda: figure_competing_models(self.findings), ax)

    def plot_ranking(self, ax: Any = None) -> Picture:
        """All explanations tried, by how they predict held-out windows."""
        return picture_of(lambda: figure_ranking(self.diagnosis), ax)

    def plot_laws(self) -> list[Picture]:
        """Each unknown law's force over position and speed, beside what its joint lacks; [] where none was found."""
        robot = self.diagnosis.case.robot
        return [Picture(figure_law(law, joint_unit(robot, law.joint))) for law in self.diagnosis.laws]

    def latex(self) -> list[str]:
        """The equation of each entry of `what`, in LaTeX's mathematics."""
        return [latex(entry["equation"]) for entry in self.findings["what"]]

    def write(self, out: str | Path, *, force: bool = False, pictures: bool = True) -> Path:
        """Write all results into a folder, as the command does; gives the report's path.

        Args:
            out: the folder.
            force: remove what an earlier run wrote there.
            pictures: show the robots in the report, where something here can draw them.

        Raises:
            InputError: the folder holds results and `force` is not set.
        """
        return write_explanation(open_run(out, force=force), self.diagnosis, self.findings, pictures=pictures)[0]

    def __repr__(self) -> str:
        return self.summary()

    def _repr_html_(self) -> str:
        return explain_table(self.findings)
