"""Options of `explain`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal, final

import tyro

from estexp_jax.api.options.ranges import SEEDS, CheckedOptions, Range


@final
@dataclass(frozen=True)
class ExplainOptions(CheckedOptions):
    """Find the physics that a simulator lacks: locate, name, model, prove on recordings that were not fitted.

    Example:
        estexp explain recordings.toml --out out/explain
        estexp explain nominal.xml a.csv b.csv --test c.csv --map ctrl.servo=goal_position --out out/explain
        estexp explain nominal.xml today.csv --healthy before_1.csv before_2.csv --out out/change
    """

    files: Annotated[tyro.conf.Positional[tuple[str, ...]], tyro.conf.arg(metavar="FILE [FILE ...]")]
    """A recordings.toml; or the nominal MJCF model and logs of its robot."""
    out: Annotated[Path, tyro.conf.arg(metavar="DIR")]
    """Where findings.json, report.html, model_explained.xml, effects.json and predictions/ go."""
    test: Annotated[
        tyro.conf.UseAppendAction[tuple[tuple[str, ...], ...]], tyro.conf.arg(metavar="FILE [FILE ...]")
    ] = ()
    """Logs that are kept for the proof; without any, the last one given."""
    healthy: Annotated[
        tyro.conf.UseAppendAction[tuple[tuple[str, ...], ...]], tyro.conf.arg(metavar="FILE [FILE ...]")
    ] = ()
    """Logs of the same robot when it was well: what changed since is explained, and that alone."""
    map: Annotated[tyro.conf.UseAppendAction[tuple[str, ...]], tyro.conf.arg(metavar="OURS=THEIRS")] = ()
    """A column of the logs that has another name than ours."""
    root: Annotated[Path | None, tyro.conf.arg(metavar="DIR")] = None
    """The folder under which the model finds its files. Default: the repository or package around it, else three
    folders up."""
    window: Annotated[float | str, Range(1e-3, math.inf, words=("full",)), tyro.conf.arg(metavar="S|full")] = 2.0
    """Length of the windows that are compared and written, s; or `full`, whole recordings."""
    most: Annotated[int, Range(1, 100)] = 5
    """Largest number of effects in an explanation; more than three only where these explain most of the mismatch."""
    effects: tuple[str, ...] = ()
    """Names of the effects to consider; without any, all."""
    engine: Literal["auto", "lanes", "c", "mjx"] = "auto"
    """What simulates: lanes, the fast one, where it can simulate the robot; else c, MuJoCo itself (mjx on a GPU)."""
    for_: Annotated[Literal["mujoco", "mjx"], tyro.conf.arg(name="for")] = "mujoco"
    """What simulates model_explained.xml later: for mjx, it keeps to the elements that MJX has."""
    seed: Annotated[int, SEEDS] = 0
    """Of the resampling behind probabilities and intervals."""
    pictures: bool = True
    """Show the robots, as recorded and as predicted, in one scene in the report, where a GL is."""
    force: bool = False
    """Replace the results in DIR."""
    resume: bool = False
    """Go on with an interrupted explanation."""
