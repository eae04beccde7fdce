"""What all studies share: their options, where their results go, and what is published beside their README.

A study is a folder with a `run.py`. `estexp experiment` hands --quick, --resume, --workers, --ray and --out on to it.
"""

from __future__ import annotations

import argparse
import shutil
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

from estexp_jax.cli.interruption import INTERRUPTED, Interruptible
from estexp_jax.errors import InputError, unwritable

ROOT = Path(__file__).resolve().parents[2]
_PUBLISHED = (".parquet", ".json", ".md", ".png", ".npz", ".jpg", ".mp4")
_INPUT_IS_WRONG = 2


@final
@dataclass(frozen=True)
class Study:
    """A study by its folder.

    Attributes:
        script: path of its `run.py`.
        about: docstring of that, or of the module that does the command.
        command: where the study's program has several.
    """

    script: Path
    about: str | None
    command: str = ""

    @classmethod
    def of(cls, script: str, about: str | None) -> Study:
        """The study of a `run.py`, which gives its `__file__` and `__doc__`."""
        return cls(Path(script).resolve(), about)

    @property
    def folder(self) -> Path:
        """Where it stands, with its README."""
        return self.script.parent

    @property
    def name(self) -> str:
        """Of its folder."""
        return self.folder.name

    def parser(self, quick: str = "few and short runs: shows that everything works") -> argparse.ArgumentParser:
        """A parser of the options that all studies have, for a study to add its own.

        Args:
            quick: what --quick does.
        """
        form = argparse.RawTextHelpFormatter
        prog = f"{self.name} {self.command}".strip()
        parser = argparse.ArgumentParser(prog=prog, description=self.about, formatter_class=form)
        parser.add_argument("--quick", action="store_true", help=quick)
        parser.add_argument("--resume", action="store_true", help="go on with what an earlier run left")
        parser.add_argument("--workers", type=int, default=None, help="runs at a time; default 1")
        parser.add_argument("--ray", nargs="?", const="local", default=None, metavar="ADDRESS", help=_RAY)
        parser.add_argument("--out", type=Path, default=None, help=f"default: out/experiments/{self.name}")
        parser.add_argument("--publish", action="store_true", help="copy tables and figures beside the README")
        return parser

    def results(self, out: Path | None, *parts: str) -> Path:
        """The folder of results, made where it is missing; absolute, as workers have other current folders.

        Args:
            out: what --out says; None: out/experiments and the study's name.
            *parts: folders in it.

        Raises:
            InputError: it cannot be written.
        """
        folder = (out or ROOT / "out" / "experiments" / self.name / self.command).resolve().joinpath(*parts)
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise unwritable(folder, error) from None
        return folder

    def publish(self, folder: Path, wanted: bool) -> None:
        """Say where the results are; where wanted, copy tables and figures beside the README."""
        for file in sorted(folder.iterdir()):
            if file.suffix in _PUBLISHED:
                print(f"wrote {file}")
                if wanted:
                    shutil.copy(file, self.folder / file.name)


_RAY = "runs as Ray tasks, --out on a folder that all machines share; without an address, a Ray of its own"


def exit_code(main: Callable[[], int]) -> int:
    """Run a study's `main`; gives the exit code, as of a command: 2 for a wrong input, 3 for an interruption."""
    with Interruptible() as interruptible:
        return _ended(main, interruptible)


def _ended(main: Callable[[], int], interruptible: Interruptible) -> int:
    try:
        return main()
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return _INPUT_IS_WRONG
    except BaseException as error:
        if not (interruptible.received or isinstance(error, KeyboardInterrupt)):
            raise
        interruptible.tell()
        return INTERRUPTED


def words(arguments: Sequence[str] | None) -> list[str]:
    """The command line of a study: what it is given, else that of the process."""
    return list(sys.argv[1:] if arguments is None else arguments)
