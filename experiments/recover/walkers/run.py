"""`estexp experiment walkers`: a library of evolved walkers, for studies that need many different gaits.

Each is the best of a short exploration of its own on the healthy quadruped; seeds below 1000.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

SHORT = {"population": 64, "generations": 15, "steps": 300}


def main(arguments: Sequence[str] | None = None) -> int:
    """Evolve what is missing, write them all into one file."""
    import numpy as np

    from estexp_jax.runs.files import replacing
    from experiments.harness.options import options_of
    from experiments.harness.recovery_runs import each
    from experiments.harness.study import Study

    study = Study.of(__file__, __doc__)
    options = options_of(study, arguments, seeds=100, quick_seeds=3)
    options.store.mkdir(parents=True, exist_ok=True)
    found = each("walkers", [(walker, seed, options.store) for seed in range(options.n)], options)
    weights = np.stack([w for w, _ in found])
    distances = np.array([d for _, d in found])
    with replacing(options.out / "walkers.npz") as stream:
        np.savez_compressed(stream, percent=np.round(100 * weights).astype(np.int8), distance=distances)
    print(f"{options.n} walkers, distance in {SHORT['steps']} steps: median {np.median(distances):.2f} m")
    study.publish(options.out, options.publish)
    return 0


def walker(seed: int, store: Path):
    """The best controller of one exploration (n_weights,), and how far it comes, m."""
    from dataclasses import replace

    from estexp_jax.recovery.config import Settings
    from estexp_jax.recovery.cycle import job_of, run_cycle
    from estexp_jax.runs import load_checkpoint, save_checkpoint
    from experiments.harness.world import quadruped, short_world

    path = store / f"walker-{seed}.npz"
    if not path.is_file():
        settings = replace(Settings(situation=None, seed=seed), **SHORT)
        *_, state = _explored(run_cycle(job_of(quadruped(), settings, world=short_world())))
        save_checkpoint(path, (state.controllers[0], state.simulated[0]))
    return load_checkpoint(path)


def _explored(states):
    for state in states:
        yield state
        if state.controllers:
            return


if __name__ == "__main__":
    from experiments.harness.study import exit_code

    sys.exit(exit_code(main))
