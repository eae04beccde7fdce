"""The command line of an experiment, and where its results go."""

from __future__ import annotations

import argparse
import shutil
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from estexp_jax.errors import InputError, unwritable
from estexp_jax.runs.workers import Crew, crew_of
from experiments.harness.recovery_case import SIZES, Size

ROOT = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Options:
    """What an experiment is told.

    Attributes:
        size: of its runs.
        n: seeds.
        workers: runs at a time; None: one, and with Ray as many as its machines have room for.
        ray: address of a Ray cluster, or `local`; None: processes of this machine.
        out: where its tables and figures go.
        store: where its runs go; experiments on the same runs share it.
        publish: whether tables and figures are copied beside the experiment's README.
    """

    size: Size
    n: int
    workers: int | None
    ray: str | None
    out: Path
    store: Path
    publish: bool

    def crew(self) -> Crew:
        """Who does the runs."""
        return crew_of(self.workers, self.ray, [str(ROOT)])


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
    parser.add_argument("--workers", type=int, default=None, help="runs at a time; default 1")
    parser.add_argument("--ray", nargs="?", const="local", default=None, metavar="ADDRESS", help=_RAY)
    parser.add_argument("--size", choices=list(SIZES), default="full", help="of the runs; full is the paper's")
    parser.add_argument("--seeds", type=int, default=None, help=f"how many, default {seeds}")
    parser.add_argument("--out", type=Path, default=None, help="default: out/experiments")
    parser.add_argument("--publish", action="store_true", help="copy tables and figures beside the README")
    given = parser.parse_args(sys.argv[1:] if arguments is None else list(arguments))
    size: Size = "quick" if given.quick else given.size
    out = (given.out or ROOT / "out" / "experiments").resolve()  # workers have other current folders
    n = given.seeds or (quick_seeds if given.quick else seeds)
    folder = _made(out / size / name)
    return Options(size, n, given.workers, given.ray, folder, out / size / "runs", given.publish)


_RAY = "runs as Ray tasks, --out on a folder that all machines share; without an address, a Ray of its own"


def _made(folder: Path) -> Path:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise unwritable(folder, error) from None
    return folder


def exit_code(main: Callable[[], int]) -> int:
    """Run an experiment's `main`; gives the exit code, as of a command: 2 for a wrong input, 3 for an interruption."""
    try:
        return main()
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("\ninterrupted; the same command goes on", file=sys.stderr)
        return 3


def publish(options: Options, script: str) -> None:
    """Say where the results are; where asked for, copy them beside the script."""
    for file in sorted(options.out.iterdir()):
        if file.suffix in (".csv", ".json", ".png", ".npz", ".jpg", ".mp4"):
            print(f"wrote {file}")
            if options.publish:
                shutil.copy(file, Path(script).resolve().parent / file.name)
