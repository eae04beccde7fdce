"""Options of `demo`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, final

import tyro

from estexp_jax.api.options.ranges import SEEDS, CheckedOptions


@final
@dataclass(frozen=True)
class DemoOptions(CheckedOptions):
    """See both jobs at work: a damaged quadruped recovers, and a leg's concealed friction is found.

    Takes some minutes on two cores, the first time a minute more for compilation.

    Example:
        estexp demo --out out/demo
    """

    out: Annotated[Path, tyro.conf.arg(metavar="DIR")] = Path("out/demo")
    """Where the results go: recover/, recorded/ and explain/."""
    seed: Annotated[int, SEEDS] = 0
    """Of all random numbers."""
    force: bool = False
    """Replace the results in DIR."""
    resume: bool = False
    """Go on with an interrupted demo."""
