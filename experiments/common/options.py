"""The command line of an experiment, and where its results go."""

from __future__ import annotations

import argparse
import shutil
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from experiments.common.case import SIZES, Size

ROOT = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Options:
    """What an experiment is told.

    Attributes:
        size: of its runs.
        n: seeds.
        workers: processes at a time.
        out: where its tables and figures go.
        store: where its runs go; experiments on the same runs share it.
        publish: whether tables and figures are copied beside the experiment's README.
    """

    size: Size
    n: int
    workers: int
    out: Path
    store: Path
    publish: bool


def parsed(name: str, doc: str | None, *, seeds: int, quick_seeds: int, arguments: Sequence[str] | None) -> Options:
    """The options of an experiment.

    Args:
        name: of its folder.
        doc: its docstring.
        seeds: how many there are by default.
        quick_seeds: and with `--quick`.
        arguments: of the command line; None: those of the process.
    """
    parser = argparse.ArgumentParser(prog=name, description=doc, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="few and short runs: shows that everything works")
    parser.add_argument("--resume", action="store_true", help="finished runs are always kept, so this changes nothing")
    parser.add_argument("--workers", type=int, default=1, help="runs at a time")
    parser.add_argument("--size", choices=list(SIZES), default="full", help="of the runs; full is the paper's")
    parser.add_argument("--seeds", type=int, default=None, help=f"how many, default {seeds}")
    parser.add_argument("--out", type=Path, default=None, help="default: out/experiments")
    parser.add_argument("--publish", action="store_true", help="copy tables and figures beside the README")
    given = parser.parse_args(sys.argv[1:] if arguments is None else list(arguments))
    size: Size = "quick" if given.quick else given.size
    out = given.out or ROOT / "out" / "experiments"
    n = given.seeds or (quick_seeds if given.quick else seeds)
    folder = out / size / name
    folder.mkdir(parents=True, exist_ok=True)
    return Options(size, n, given.workers, folder, out / size / "runs", given.publish)


def publish(options: Options, script: str) -> None:
    """Say where the results are; where asked for, copy them beside the script."""
    for file in sorted(options.out.iterdir()):
        if file.suffix in (".csv", ".json", ".png", ".npz", ".jpg", ".mp4"):
            print(f"wrote {file}")
            if options.publish:
                shutil.copy(file, Path(script).resolve().parent / file.name)
