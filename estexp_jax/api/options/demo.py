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
    """See both jobs at work: a leg's concealed delay is found, and a damaged quadruped recovers.

    Takes two or three minutes on two cores. Where `mujoco.sysid` is installed, its answer stands beside the first.

    Example:
        estexp demo --out out/demo
    """

    out: Annotated[Path, tyro.conf.arg(metavar="DIR")] = Path("out/demo")
    """Where the results go: recorded/, explain/ and recover/."""
    seed: Annotated[int, SEEDS] = 0
    """Of all random numbers."""
    force: bool = False
    """Replace the results in DIR."""
    resume: bool = False
    """Go on with an interrupted demo."""
