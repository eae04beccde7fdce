"""The subcommands of `estexp`: finds the one that arguments name, and turns its end into an exit code."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Sequence
from difflib import get_close_matches
from inspect import cleandoc
from pathlib import Path
from typing import Annotated, Any, Union

import estexp_jax
from estexp_jax.errors import InputError, known, name_too_long

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
"""The subcommands, in the help's order. For each, `api/options/<name>.py` has `<Name>Options`, a frozen dataclass whose
docstrings are the help (its own ends with an example); `cli/<name>.py` has `<name>_command(options) -> int`, the exit
code. Help needs only the options, so what computes is imported when a command runs."""

_SUMMARY = (
    "Finds what broke on a robot, or what physics its simulator lacks, by searching simulations until they "
    "reproduce its sensors. `estexp COMMAND --help` explains a command; `estexp --version` prints the version."
)
_FILES = (".xml", ".urdf", ".toml", ".csv")
_ASKED = {
    "help": "--help",
    "version": "--version",
    "fit": "explain",
    "diagnose": "explain",
    "identify": "explain",
    "simulate": "record",
}
"""What is asked for by other words."""
DONE, DEFECT, WRONG_INPUT = 0, 1, 2


def run_command(argv: Sequence[str]) -> int:
    """Run what the arguments after `estexp` say.

    Returns:
        The exit code, as `main` gives it.

    Raises:
        KeyboardInterrupt: it was interrupted.
    """
    arguments = list(argv)
    if arguments[:1] == ["--version"]:
        return _print_version()
    try:
        options = _parsed(arguments)
        from estexp_jax.api.session import command_session

        with command_session():
            return _run_of(options)(options)
    except SystemExit as end:  # after --help, or after a message about wrong usage
        return end.code if isinstance(end.code, int) else DONE
    except InputError as error:
        return _refused(error)
    except OSError as error:
        refusal = name_too_long(error)
        if refusal is None:
            raise
        return _refused(refusal)


def _refused(error: InputError) -> int:
    print(f"estexp: error: {error}", file=sys.stderr)
    return WRONG_INPUT


def _print_version() -> int:
    print(f"estexp {estexp_jax.__version__}")
    return DONE


def _parsed(arguments: list[str]) -> Any:
    """The options of the command that the arguments name. Ends the program after `--help` or a wrong usage."""
    import tyro

    settings = (tyro.conf.FlagCreatePairsOff,)
    if arguments and arguments[0] in COMMANDS:
        options = _options_of(arguments[0])
        # The whole docstring: left to itself, tyro would drop the example as a section of its own.
        texts: dict[str, Any] = {"prog": f"estexp {arguments[0]}", "description": cleandoc(options.__doc__ or "")}
        return tyro.cli(options, **texts, args=arguments[1:], config=settings)
    if arguments and not arguments[0].startswith("-"):
        raise _unknown_command(arguments)
    choices: Any = Union[tuple(_choice(name) for name in COMMANDS)]  # noqa: UP007
    texts = {"prog": "estexp", "description": _SUMMARY}
    return tyro.cli(choices, **texts, args=arguments, config=settings)


def _unknown_command(arguments: Sequence[str]) -> InputError:
    """The message about a first word that is no command: the nearest one, or what a file or a question asks for."""
    word = arguments[0]
    near = get_close_matches(word.lower(), COMMANDS, n=1, cutoff=0.5)
    if Path(word).suffix.lower() in _FILES:
        suggested = " ".join(("explain", *arguments))
    else:
        suggested = near[0] if near else _ASKED.get(word.lower(), "")
    meant = f"did you mean `estexp {suggested}`? " if suggested else ""
    return InputError(f"there is no command '{word}'", right=f"{meant}{known(COMMANDS)}")


def _choice(name: str) -> Any:
    import tyro

    options = _options_of(name)
    texts: dict[str, Any] = {"description": cleandoc(options.__doc__ or "").partition("\n")[0]}
    return Annotated[options, tyro.conf.subcommand(name, **texts)]


def _options_of(name: str) -> Any:
    """The options class of a command."""
    return getattr(importlib.import_module(f"estexp_jax.api.options.{name}"), f"{name.capitalize()}Options")


def _run_of(options: Any) -> Callable[[Any], int]:
    """The function that runs a command with such options."""
    name = type(options).__module__.rpartition(".")[2]
    return getattr(importlib.import_module(f"estexp_jax.cli.{name}"), f"{name}_command")
