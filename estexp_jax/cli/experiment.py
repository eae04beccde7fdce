"""`estexp experiment`: run a folder of experiments as its own process."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

from estexp_jax.api.options.experiment import ExperimentOptions
from estexp_jax.cli.interruption import INTERRUPTED
from estexp_jax.errors import InputError, known
from estexp_jax.runs.cluster import check_installed

EXPERIMENTS = Path("experiments")
"""Where experiments are looked for, from the current folder."""

_HEARD_S = 2.0
"""Time for an experiment to end by itself where a signal has reached it, too."""


def experiment_command(options: ExperimentOptions) -> int:
    """Run the experiment's `run.py` and wait for it.

    Returns:
        Its exit code; 3 where it was interrupted, 1 where another signal killed it.

    Raises:
        InputError: there is no such experiment; lists those that exist. There are several addresses, or Ray is not
            installed.
    """
    if options.ray is not None:
        _check_ray(options.ray)
    script = find(options.name, EXPERIMENTS) / "run.py"
    return _exit_code(_wait(subprocess.Popen([sys.executable, str(script), *_arguments(options)])))


def find(name: str, experiments: Path) -> Path:
    """The folder of an experiment.

    Args:
        name: of a study's folder in `experiments` or in one of its groups (`planted`), with its group
            (`explain/planted`), or a path.
        experiments: where they are.

    Raises:
        InputError: none has a `run.py`, or several groups have a study of this name; lists what exists.
    """
    there = studies(experiments)
    named = [there[name]] if name in there else [folder for folder in there.values() if folder.name == name]
    if len(named) == 1:
        return named[0]
    if len(named) > 1:
        names = [folder.relative_to(experiments).as_posix() for folder in named]
        raise InputError(f"there are {len(named)} experiments '{name}'", right=f"one of {', '.join(names)}")
    if (Path(name) / "run.py").is_file():
        return Path(name)
    right = f"a path, or a folder of {experiments.resolve()} with a run.py; {known(_short_names(there))}"
    raise InputError(f"there is no experiment '{name}'", right=right)


def studies(experiments: Path) -> dict[str, Path]:
    """Folders with a `run.py`, by their paths in `experiments`; groups are one level deep."""
    scripts = [*experiments.glob("*/run.py"), *experiments.glob("*/*/run.py")]
    return {s.parent.relative_to(experiments).as_posix(): s.parent for s in sorted(scripts)}


def _short_names(there: dict[str, Path]) -> list[str]:
    """Names of studies, with their group only where two groups have the same one."""
    leaves = [folder.name for folder in there.values()]
    return sorted(f.name if leaves.count(f.name) == 1 else path for path, f in there.items())


def _arguments(options: ExperimentOptions) -> list[str]:
    flags = [f"--{name}" for name in ("quick", "resume") if getattr(options, name)]
    workers = [] if options.workers is None else ["--workers", str(options.workers)]
    ray = [] if options.ray is None else ["--ray", *options.ray]
    out = [] if options.out is None else ["--out", str(options.out)]
    return [*flags, *workers, *ray, *out]


def _check_ray(addresses: tuple[str, ...]) -> None:
    """Refuse what is wrong before anything runs."""
    if len(addresses) > 1:
        raise InputError(f"has {len(addresses)} addresses", where="--ray", right="one, or none; NAME goes before it")
    check_installed()


def _wait(process: subprocess.Popen[bytes]) -> int:
    """The process's return code. Ctrl-C reaches it as well as us; of a signal for us alone it is told."""
    try:
        return process.wait()
    except KeyboardInterrupt:
        try:
            return process.wait(_HEARD_S)
        except subprocess.TimeoutExpired:
            process.terminate()
            return process.wait()


def _exit_code(code: int) -> int:
    if code >= 0:
        return code
    if code in (-signal.SIGINT, -signal.SIGTERM, -signal.SIGHUP):
        return INTERRUPTED
    print(f"estexp: the experiment was killed by {signal.Signals(-code).name}", file=sys.stderr)
    return 1
