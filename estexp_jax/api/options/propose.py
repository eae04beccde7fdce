"""Options of `propose`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal, final

import tyro

from estexp_jax.api.options.ranges import SEEDS, CheckedOptions, Range


@final
@dataclass(frozen=True)
class ProposeOptions(CheckedOptions):
    """Find what to record next: the motion on which the explanations that are left disagree most.

    Writes commands.csv, rivals/<n>.csv (what each explanation predicts), advice.md and report.html.

    Example:
        estexp explain recordings.toml --out out/explain
        estexp propose out/explain --out out/propose
    """

    folder: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="DIR")]
    """Where `estexp explain` wrote its results."""
    out: Annotated[Path, tyro.conf.arg(metavar="DIR")]
    """Where commands, predictions, advice and report go."""
    duration: Annotated[float, Range(1.0, 600.0)] = 8.0
    """Of the motion, s."""
    margin: Annotated[float, Range(0.01, 1.0)] = 0.9
    """Share of each range of command, joint and motor force that may be used."""
    speed: Annotated[float, Range(0.01, 1e6)] = 3.0
    """How many times as fast as in the recordings joints may move."""
    engine: Literal["auto", "lanes", "c", "mjx"] = "auto"
    """What simulates: lanes, the fast one, where it can simulate the robot; else c, MuJoCo itself (mjx on a GPU)."""
    seed: Annotated[int, SEEDS] = 0
    """Of the search."""
    force: bool = False
    """Replace the results in DIR."""
    resume: bool = False
    """Go on with an interrupted search; short as it is, it is done again."""
