"""Options of `bench`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, final

import tyro

from estexp_jax.api.options.ranges import SEEDS, CheckedOptions, Range


@final
@dataclass(frozen=True)
class BenchOptions(CheckedOptions):
    """Measure how fast this machine simulates: serial C, C on all cores, MJX and lanes, in turns, on the same robots.

    No engine is timed before its physics has been compared with the C engine's. Writes bench.json, bench.png and
    bench.svg. A quiet machine gives truer numbers; some minutes, with --sweep some more.

    Example:
        estexp bench --out out/bench --sweep
    """

    out: Annotated[Path, tyro.conf.arg(metavar="DIR")]
    """Where the results go."""
    model: Annotated[Path | None, tyro.conf.arg(metavar="MODEL.xml")] = None
    """Another robot than the quadruped: an MJCF that can walk, with motors and with touch or jointpos sensors."""
    feet: bool = False
    """The quadruped with its four feet as only contacts."""
    sweep: bool = False
    """Go through populations from 1 to 6400 as well."""
    explain: bool = False
    """Time explaining shipped logs as well, beside mujoco.sysid where it is installed; some minutes more."""
    population: Annotated[int, Range(1, 1_000_000)] = 200
    """Robots."""
    steps: Annotated[int, Range(1, 1_000_000)] = 1000
    """Control steps."""
    substeps: Annotated[tuple[int, ...], Range(1, 10_000)] = ()
    """Physics steps a control step; one race for each. Default: as shipped (the quadruped: 4), and 1."""
    repeats: Annotated[int, Range(1, 1000)] = 5
    """How often each engine is timed; medians count."""
    seed: Annotated[int, SEEDS] = 0
    """Of controllers and of what differs from robot to robot."""
    quick: bool = False
    """Few robots, few steps: shows that everything works, measures little."""
    force: bool = False
    """Replace the results in DIR."""
    resume: bool = False
    """Go on with an interrupted bench; its numbers belong together, so it is done again."""
