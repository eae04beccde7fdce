"""`estexp bench`: this machine's simulation speed, side by side with the serial baseline."""

from __future__ import annotations

from rich import box
from rich.console import Console
from rich.table import Table

from estexp_jax.api.bench import BenchResult, bench_to_folder
from estexp_jax.api.options.bench import BenchOptions


def bench_command(options: BenchOptions) -> int:
    """Measure, write, and print.

    Raises:
        InputError: the model or a number cannot be used, or DIR.
    """
    written = bench_to_folder(options)
    _print_result(written.result)
    print(f"Numbers: {written.json_file}\nFigure: {written.figure}")
    return 0


def _print_result(result: BenchResult) -> None:
    console = Console(highlight=False)
    for each, refused in result.tables():
        table = Table(title=each.title, title_justify="left", box=box.SIMPLE)
        for name in each.header:
            table.add_column(name, justify="left" if name == "engine" else "right", no_wrap=True)
        for row in each.rows:
            table.add_row(*row)
        console.print(table)
        for sentence in refused:
            console.print(sentence, markup=False, soft_wrap=True)
    print("\n".join(result.sentences()))
