"""`explain` from Python and Jupyter."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any, final

from estexp_jax.api.inputs import Inputs, read_inputs
from estexp_jax.discovery.diagnosis import Case, Diagnosis, ExplainConfig, explaining
from estexp_jax.discovery.explain import explain as _explain
from estexp_jax.discovery.fitting import Progress as Step
from estexp_jax.discovery.telling_laws import joint_unit
from estexp_jax.recordings.roles import assign_roles
from estexp_jax.recordings.settings import apply_settings
from estexp_jax.report.drawing.picture import Picture
from estexp_jax.runs import count_compilations, enable_compilation_cache, forget_programs, versions


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
        """The verdict, what is missing, and how much better unseen recordings are predicted."""
        from estexp_jax.report.explain.text import explain_summary

        return explain_summary(self.findings)

    def table(self) -> Any:
        """The claimed effects, one parameter a row: a DataFrame where pandas is present, else a list of dicts."""
        from estexp_jax.report.explain.text import explain_rows

        try:
            from pandas import DataFrame  # pyright: ignore[reportMissingImports] (a guest, not a dependency)
        except ImportError:
            return explain_rows(self.findings)
        return DataFrame(explain_rows(self.findings))

    def plot_where(self) -> Picture:
        """Where the error is."""
        from estexp_jax.report.explain.figures import figure_where

        return Picture(figure_where(self.diagnosis))

    def plot_fit(self) -> Picture:
        """A test recording, before and after."""
        from estexp_jax.report.explain.figures import figure_fit

        return Picture(figure_fit(self.diagnosis))

    def plot_rivals(self) -> Picture:
        """Test and training errors of the nominal simulator, the rivals and the explanation."""
        from estexp_jax.report.explain.competing_models import figure_competing_models

        return Picture(figure_competing_models(self.findings))

    def plot_ranking(self) -> Picture:
        """All explanations tried, by how they predict held-out windows."""
        from estexp_jax.report.explain.figures import figure_ranking

        return Picture(figure_ranking(self.diagnosis))

    def plot_laws(self) -> list[Picture]:
        """Each unknown law's force over position and speed, beside what its joint lacks; [] where none was found."""
        from estexp_jax.report.explain.law_figure import figure_law

        robot = self.diagnosis.case.robot
        return [Picture(figure_law(law, joint_unit(robot, law.joint))) for law in self.diagnosis.laws]

    def latex(self) -> list[str]:
        """The equation of each entry of `what`, in LaTeX's mathematics."""
        from estexp_jax.report.explain.latex import latex

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
        from estexp_jax.api.explain_files import write_results
        from estexp_jax.runs import open_run

        return write_results(open_run(out, force=force), self.diagnosis, self.findings, pictures=pictures)[0]

    def __repr__(self) -> str:
        return self.summary()

    def _repr_html_(self) -> str:
        from estexp_jax.report.explain.text import explain_table

        return explain_table(self.findings)


def explain(
    model: str | Path,
    recordings: Sequence[str | Path] = (),
    *,
    test: Sequence[str | Path] = (),
    map: Iterable[str] = (),  # noqa: A002 (the command's word)
    window: float = 2.0,
    most: int = 5,
    effects: Sequence[str] | None = None,
    seed: int = 0,
    engine: str = "auto",
    progress: Callable[[Step], None] | None = None,
) -> ExplainResult:
    """Find the physics that a simulator lacks, from recordings of the robot.

    Args:
        model: the nominal MJCF; or a `recordings.toml` that names model, recordings and columns.
        recordings: logs to learn from, one file each.
        test: logs to prove it on. Without any, the last recording is kept back; of a single one, its last 30 %.
        map: `ours=theirs` for logs with other column names.
        window: length of the windows compared, s; infinite for whole recordings.
        most: largest number of effects in an explanation.
        effects: names of the effects to consider; None: all that it can, and those that were registered.
        seed: of the resampling behind probabilities and intervals.
        engine: auto, lanes or mjx.
        progress: called with each step of the work.

    Raises:
        InputError: a file is wrong or the model cannot be simulated.
    """
    inputs = read_inputs([str(model), *map_str(recordings)], test=map_str(test), maps=list(map))
    config = explain_config_of(window, most, effects, seed, engine)
    return run_explanation(inputs, config, {}, progress or _ignore)


def map_str(paths: Sequence[str | Path]) -> list[str]:
    """Paths as text."""
    return [str(path) for path in paths]


def explain_config_of(
    window: float, most: int, effects: Sequence[str] | None, seed: int, engine: str = "auto"
) -> ExplainConfig:
    """The configuration of these choices.

    Raises:
        InputError: an unknown effect, or a window or number that makes no sense.
    """
    from estexp_jax.errors import InputError, known
    from estexp_jax.physics.engines.choice import ENGINES

    if not window > 0.0:
        raise InputError(f"a window of {window} s is no window", where="--window", right="a length in s, or 'full'")
    if engine not in ENGINES:
        raise InputError(f"there is no engine '{engine}'", where="--engine", right=known(ENGINES))
    if most < 1:
        raise InputError(f"{most} effects explain nothing", where="--most", right="1 or more")
    every = explaining()
    chosen = every if effects is None else tuple(effects)
    for name in chosen:
        if name not in every:
            raise InputError(f"'{name}' is not an effect to explain with", where="--effects", right=known(every))
    return ExplainConfig(window=window, most=most, effects=chosen, seed=seed, engine=engine)


def case_of(inputs: Inputs) -> Case:
    """Recordings with their roles, and the nominal robot under each one's settings.

    Raises:
        InputError: no recording is left to learn from, or names clash.
    """
    recordings = tuple(assign_roles(inputs.recordings))
    robots = tuple(apply_settings(inputs.robot, r.settings, where=r.name) for r in recordings)
    return Case(inputs.robot, recordings, robots)


def run_explanation(
    inputs: Inputs, config: ExplainConfig, memory: dict[str, Any], report: Callable[[Step], None]
) -> ExplainResult:
    """Explain, timing it.

    Args:
        inputs: what was read.
        config: how to explain.
        memory: state of an interrupted explanation; filled as this one goes on.
        report: called after each step, when `memory` is up to date.
    """
    enable_compilation_cache()
    forget_programs()
    begin = perf_counter()
    with count_compilations() as compiled:
        steps = _explain(case_of(inputs), config, memory)
        while True:
            try:
                report(next(steps))
            except StopIteration as end:
                diagnosis: Diagnosis = end.value
                break
    cost = {**diagnosis.findings["cost"], "wall_s": perf_counter() - begin, "compile_s": compiled.seconds}
    return ExplainResult(diagnosis, {**diagnosis.findings, "cost": cost, "versions": versions()})


def _ignore(_: Step) -> None:
    pass
