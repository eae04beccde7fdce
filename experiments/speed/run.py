"""Runs the bench on the quadruped, with its twelve contacts and with its feet alone; see README.md."""

import argparse
import sys
from pathlib import Path

from estexp_jax.cli.main import main

OUT = Path("out") / "bench"


def run() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--resume", action="store_true", help="numbers belong together, so both are measured anew")
    parser.add_argument("--workers", type=int, help="only one at a time can be measured: ignored")
    parser.add_argument("--out", type=Path, default=OUT, help=f"default: {OUT}")
    given = parser.parse_args()
    options = ["--force", *(["--quick"] if given.quick else [])]
    code = main(["bench", "--out", str(given.out / "quadruped"), *options, *([] if given.quick else ["--sweep"])])
    return code or main(["bench", "--out", str(given.out / "feet"), "--feet", *options])


if __name__ == "__main__":
    sys.exit(run())
