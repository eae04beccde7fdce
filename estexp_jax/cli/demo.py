"""`estexp demo`: both jobs, from nothing but the package."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

_CONCEALED = "coulomb_friction@knee T=0.6"


@dataclass(frozen=True)
class Options:
    """See both jobs at work: a damaged quadruped recovers, and a leg's concealed friction is found.

    Takes some minutes on two cores, the first time a minute more for compilation.

    Example:
        estexp demo --out out/demo
    """

    out: Annotated[Path, tyro.conf.arg(metavar="DIR")] = Path("out/demo")
    """Where the results go: recover/, recorded/ and explain/."""
    seed: int = 0
    """Of all random numbers."""
    force: bool = False
    """Replace the results in DIR."""
    resume: bool = False
    """Go on with an interrupted demo."""


def run(options: Options) -> int:
    """Recover, record, explain.

    Raises:
        InputError: DIR cannot be used.
    """
    from estexp_jax.cli import explain, record, recover
    from estexp_jax.package_data import model_path

    force, resume = options.force, options.resume
    print("1. A quadruped loses a leg, and walks again.\n")
    walking = options.out / "recover"
    recover.run(recover.Options(out=walking, situation=3, seed=options.seed, quick=True, force=force, resume=resume))
    print("\n2. A leg rubs in its knee, and its simulator does not know.\n")
    recorded, explained = options.out / "recorded", options.out / "explain"
    leg = model_path("leg")
    anew = force or resume  # recording takes seconds, so it is not gone on with
    record.run(record.Options(leg, recorded, effect=(_CONCEALED,), seed=options.seed, duration=6.0, force=anew))
    explain.run(explain.Options((str(recorded / "recordings.toml"),), explained, force=force, resume=resume))
    print(f"\nThe two reports:\n  {walking / 'report.html'}\n  {explained / 'report.html'}")
    return 0
