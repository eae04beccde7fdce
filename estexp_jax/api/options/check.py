"""Options of `check`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, final

import tyro

from estexp_jax.api.options.ranges import CheckedOptions


@final
@dataclass(frozen=True)
class CheckOptions(CheckedOptions):
    """Read and judge recordings: clock, units, sensors, saturation, lags, which joints move enough to tell what.

    Nothing is simulated or fitted. Wherever the files could be read, this succeeds, whatever it finds.

    Example:
        estexp check recordings.toml --out out/check
        estexp check nominal.xml a.csv b.csv --map ctrl.servo=goal_position --init
        estexp check robot.urdf --init
    """

    files: Annotated[tyro.conf.Positional[tuple[str, ...]], tyro.conf.arg(metavar="FILE [FILE ...]")]
    """A recordings.toml; or an MJCF or URDF model and the logs of its robot; or, with --init, a URDF alone."""
    test: Annotated[
        tyro.conf.UseAppendAction[tuple[tuple[str, ...], ...]], tyro.conf.arg(metavar="FILE [FILE ...]")
    ] = ()
    """Logs that are kept for the test."""
    map: Annotated[tyro.conf.UseAppendAction[tuple[str, ...]], tyro.conf.arg(metavar="OURS=THEIRS")] = ()
    """A column of the logs that has another name than ours."""
    root: Annotated[Path | None, tyro.conf.arg(metavar="DIR")] = None
    """The folder under which the model finds its files. Default: the repository or package around it, else three
    folders up."""
    out: Annotated[Path | None, tyro.conf.arg(metavar="DIR")] = None
    """Where to write check.json and check.png."""
    init: bool = False
    """Write a first recordings.toml for the model and the logs, to be completed by hand; into DIR, or here. For a model
    alone: a first MJCF with servos and angle sensors at all joints that have none."""
    force: bool = False
    """Replace the results in DIR."""
    resume: bool = False
    """Go on with an interrupted check; short as it is, it is done again."""
