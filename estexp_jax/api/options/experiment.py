"""Options of `experiment`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, final

import tyro

from estexp_jax.api.options.ranges import CheckedOptions, Range


@final
@dataclass(frozen=True)
class ExperimentOptions(CheckedOptions):
    """Run an experiment: all its runs, its figures, its numbers.

    An experiment is a folder with a `run.py`, in ./experiments or anywhere; it runs as its own process, whose exit code
    becomes this one's.

    Example:
        estexp experiment planted --quick
        estexp experiment recover/figure7 --ray 10.0.0.1:6379 --out /shared/experiments
    """

    name: Annotated[tyro.conf.Positional[str], tyro.conf.arg(metavar="NAME")]
    """A folder of ./experiments, with or without its group, or the path of one."""
    quick: bool = False
    """Few and short runs: shows that everything works, proves nothing."""
    resume: bool = False
    """Go on with an interrupted experiment."""
    workers: Annotated[int | None, Range(1, 10_000)] = None
    """How many runs at a time; the experiment chooses where this is not given."""
    ray: Annotated[tuple[str, ...] | None, tyro.conf.arg(metavar="[ADDRESS]")] = None
    """The runs as tasks of a Ray cluster, one GPU each where there are some; without an address, a Ray of its own."""
    out: Annotated[Path | None, tyro.conf.arg(metavar="DIR")] = None
    """Where results and checkpoints go; with --ray, a folder that all machines share. Default: the experiment's."""
