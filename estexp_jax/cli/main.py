"""The command `estexp`: finds the subcommand, and turns its end into an exit code."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Sequence
from inspect import cleandoc
from typing import Annotated, Any, Union

from estexp_jax.errors import InputError

COMMANDS = (
    "bench",
    "check",
    "demo",
    "explain",
    "experiment",
    "propose",
    "record",
    "recover",
)
"""The subcommands, in the help's order; each is a module of this folder. It has `Options`, a frozen dataclass whose
docstrings are the help (its own ends with an example), and `run(options) -> int`, the exit code. To keep `--help` fast,
modules import what computes inside `run`."""

DONE, DEFECT, WRONG_INPUT, INTERRUPTED = 0, 1, 2, 3


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command.

    Args:
        argv: the arguments after `estexp`; None: those of this process.

    Returns:
        The exit code: 0 done, 2 the input is wrong, 3 interrupted. A defect of ours is an exception, so 1.
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    if arguments[:1] == ["--version"]:
        return _print_version()
    try:
        options = _parsed(arguments)
    except SystemExit as end:  # after --help, or after telling what is wrong
        return end.code if isinstance(end.code, int) else DONE
    from estexp_jax.physics.model.validation import mujoco_warnings_suppressed
    from estexp_jax.runs import quiet_xla

    quiet_xla()
    try:
        with mujoco_warnings_suppressed():
            return _module_of(options).run(options)
    except InputError as error:
        print(f"estexp: error: {error}", file=sys.stderr)
        return WRONG_INPUT
    except KeyboardInterrupt:
        print("\nestexp: interrupted; the same command with --resume goes on", file=sys.stderr)
        return INTERRUPTED


def _print_version() -> int:
    from estexp_jax.runs.versions import version

    print(f"estexp {version('estexp_jax')}")
    return DONE


def _parsed(arguments: list[str]) -> Any:
    """The options of the command that the arguments name. Ends the program after `--help` or a wrong usage."""
    import tyro

    settings = (tyro.conf.FlagCreatePairsOff,)
    if arguments and arguments[0] in COMMANDS:
        options = _module(arguments[0]).Options
        # The whole docstring: left to itself, tyro would drop the example as a section of its own.
        description = cleandoc(options.__doc__ or "")
        prog = f"estexp {arguments[0]}"
        return tyro.cli(options, prog=prog, description=description, args=arguments[1:], config=settings)
    choices: Any = Union[tuple(_choice(name) for name in COMMANDS)]  # noqa: UP007
    description = (
        "Finds what broke on a robot, or what physics its simulator lacks, by searching simulations until they "
        "reproduce its sensors. `estexp COMMAND --help` explains a command; `estexp --version` tells the version."
    )
    return tyro.cli(choices, prog="estexp", description=description, args=arguments, config=settings)


def _choice(name: str) -> Any:
    import tyro

    options = _module(name).Options
    summary = cleandoc(options.__doc__ or "").partition("\n")[0]
    return Annotated[options, tyro.conf.subcommand(name, description=summary)]


def _module(name: str) -> Any:
    return importlib.import_module(f"estexp_jax.cli.{name}")


def _module_of(options: Any) -> Any:
    return sys.modules[type(options).__module__]


if __name__ == "__main__":
    sys.exit(main())
