"""Options of `record`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, final

import tyro

from estexp_jax.api.options.ranges import SEEDS, CheckedOptions, Range


@final
@dataclass(frozen=True)
class RecordOptions(CheckedOptions):
    """Simulate a robot with a chosen effect, and write what it would have logged.

    Writes nominal.xml, train_0.csv, train_1.csv, test_0.csv, recordings.toml, and truth.json (explain never reads it).

    Example:
        estexp record arm.xml --effect "coulomb_friction@knee T=0.5" --out out/recorded
    """

    model: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="MODEL.xml")]
    """The nominal MJCF."""
    out: Annotated[Path, tyro.conf.arg(metavar="DIR")]
    """Where the recordings go."""
    effect: Annotated[tyro.conf.UseAppendAction[tuple[str, ...]], tyro.conf.arg(metavar='"EFFECT@NAME P=VALUE"')] = ()
    """An effect that the robot has and its model lacks; none: the robot is as modelled."""
    root: Annotated[Path | None, tyro.conf.arg(metavar="DIR")] = None
    """The folder under which the model finds its files. Default: the repository or package around it, else three
    folders up."""
    duration: Annotated[float, Range(0.1, 1e5)] = 8.0
    """Of each recording, s."""
    rate: Annotated[float, Range(1.0, 1e5)] = 200.0
    """Rows a second."""
    bits: Annotated[int, Range(1, 64)] = 14
    """Resolution of the encoders."""
    noise: Annotated[float, Range(0.0, 1e3)] = 2e-4
    """Deviation of the noise on positions, rad or m."""
    seed: Annotated[int, SEEDS] = 0
    """Of motions and noise."""
    force: bool = False
    """Replace the recordings in DIR."""
    resume: bool = False
    """Go on with an interrupted recording; short as it is, it is done again."""
