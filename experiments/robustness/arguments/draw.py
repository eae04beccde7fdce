"""Command lines with one argument at the ends of its range, beyond, empty, huge or of another kind.

All are made from the dataclasses that make `--help`: an option that is added is tried without a line here.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import MISSING, fields
from importlib import import_module
from pathlib import Path
from typing import Any, Literal, get_args, get_origin, get_type_hints

from estexp_jax.api.options.ranges import Range

NO_NUMBERS = ("", " ", "x", "nan", "-inf", "1e999", "9" * 400, "1,5", "0x10", "1_0", "--")
TEXTS = (
    "",
    " ",
    "x" * 300,
    "-",
    "=",
    "@",
    "../..",
    "/dev/null",
    "/dev/full",
    "\x1b[31m",
    "[red]",
    "a\nb",
    "~",
    "\udcff",
)
BASE = {
    "bench": ("--quick",),
    "check": ("recorded/recordings.toml",),
    "demo": (),
    "explain": ("recorded/recordings.toml",),
    "experiment": (str(Path(__file__).parents[1] / "crash_recovery" / "subject"),),
    "propose": ("explained",),
    "record": ("pendulum.xml",),
    "recover": ("--quick",),
}
"""What each command has to be given, in a folder of good results."""


def options_of(command: str) -> Any:
    """The options class of a command."""
    return getattr(import_module(f"estexp_jax.api.options.{command}"), f"{command.capitalize()}Options")


def lines_of(command: str, out: Path) -> Iterator[list[str]]:
    """The command lines of a command, each with one argument that is tried."""
    options = options_of(command)
    hints = get_type_hints(options, include_extras=True)
    given = [command, *BASE[command]]
    for field in fields(options):
        flag = f"--{field.name.replace('_', '-')}"
        into = [] if field.name == "out" else ["--out", str(out)]
        parts = [*parts_of(hints[field.name])]
        if bool in parts:
            yield [*given, *into, flag, "maybe"]
        elif field.default is MISSING and field.name != "out":  # positional
            for text in TEXTS:
                yield [command, *into, "--", text] if text.startswith("-") else [command, text, *into]
        else:
            for text in texts_of(parts):
                yield [*given, *into, flag, text]
                yield [*given, *into, f"{flag}={text}"]


def texts_of(parts: list[Any]) -> list[str]:
    """What is tried of an argument, by the types, ranges and choices that its annotation consists of."""
    choices = [str(choice) for part in parts if isinstance(part, tuple) for choice in part]
    ranges = [part for part in parts if isinstance(part, Range)]
    if choices:
        return [*choices, "nope", "", choices[0].upper()]
    if not ranges:
        return list(TEXTS)
    whole = float not in parts
    return [*NO_NUMBERS, *(_written(value, whole) for each in ranges for value in ends_of(each, whole))]


def ends_of(limits: Range, whole: bool) -> list[float]:
    """The ends of a range, what is just within and what is just beyond them, and far beyond."""
    found: list[float] = [-1.0, 0.0, 1e12, -1e308, 1e308]
    for end in (limits.low, limits.high):
        if end is not None and math.isfinite(end):
            step = 1.0 if whole else max(abs(end), 1e-300) * 1e-3
            found += [end - step, end, end + step]
    return list(dict.fromkeys(found))


def _written(value: float, whole: bool) -> str:
    return str(int(value)) if whole else repr(value)


def parts_of(hint: Any) -> Iterator[Any]:
    """The types, ranges and choices (as a tuple) that an annotation consists of."""
    if get_origin(hint) is Literal:
        yield get_args(hint)
    elif hasattr(hint, "__metadata__"):
        yield from (note for note in hint.__metadata__ if isinstance(note, Range))
        yield from parts_of(get_args(hint)[0])
    elif get_args(hint):
        for inner in get_args(hint):
            yield from parts_of(inner)
    else:
        yield hint
