"""`estexp check`: read and judge recordings, before anything is fitted to them."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table
from rich.text import Text

from estexp_jax.api.check import CheckResult, check_to_folder
from estexp_jax.api.options.check import CheckOptions


def check_command(options: CheckOptions) -> int:
    """Check, print, and write what was asked for.

    Raises:
        InputError: a file cannot be read, or DIR cannot be used.
    """
    check_to_folder(options, print, _print_result)
    return 0


def _print_result(result: CheckResult) -> None:
    console = Console(highlight=False)
    for each in result.tables():
        table = Table(*each.header, title=each.title, title_justify="left")
        for row in each.rows:
            table.add_row(*(Text(cell, overflow="fold") for cell in row))
        console.print(table)
    for sentence in result.sentences():
        console.print(sentence, markup=False, soft_wrap=True)
