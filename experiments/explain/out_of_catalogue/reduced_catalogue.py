"""Explain with a smaller catalogue: `python -m THIS_MODULE --without A,B MANIFEST --out DIR`.

Beside the usual results it leaves `laws.json`: errors on each test recording, and each law's force where the
training recordings show its joint.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

import estexp_jax as ee
from estexp_jax.discovery.diagnosis import Prediction, explaining
from estexp_jax.runs import write_json


def main(arguments: list[str] | None = None) -> int:
    """Explain one case; always anew."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--without", default="", help="names, with commas between them")
    parser.add_argument("manifest", type=Path)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--resume", action="store_true", help="means --force here")
    parser.add_argument("--force", action="store_true")
    options = parser.parse_args(arguments)
    names = [name for name in explaining() if name not in options.without.split(",")]
    found = ee.explain(options.manifest, effects=names, progress=lambda step: print(step.stage, flush=True))
    found.write(options.out, force=True, pictures=False)
    tests = [p for p in found.diagnosis.predictions if p.role == "test"]
    forces = {
        "tests": {p.recording: {m: error(p, getattr(p, m)) for m in ("nominal", "explained")} for p in tests},
        "laws": [
            {name: x if isinstance(x, str) else np.round(x, 6).tolist() for name, x in law._asdict().items()}
            for law in found.diagnosis.laws
        ],
    }
    write_json(options.out / "laws.json", forces)
    return 0


def error(p: Prediction, simulated: np.ndarray) -> float:
    """Root mean square over channels of the error (RMSE over range)."""
    share = (
        np.nanmean((simulated - p.recorded) ** 2, axis=0) / (np.nanmax(p.recorded, 0) - np.nanmin(p.recorded, 0)) ** 2
    )
    return float(np.sqrt(np.mean(share)))


if __name__ == "__main__":
    sys.exit(main())
