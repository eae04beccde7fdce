"""Rows of results as text, as HTML, or as a DataFrame if pandas is installed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from typing import Any, NamedTuple


class TextTable(NamedTuple):
    """A table of texts."""

    title: str
    header: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]

    def text(self) -> str:
        """The title, and one line for each row with aligned columns."""
        cells = [self.header, *self.rows]
        widths = [max(len(row[i]) for row in cells) for i in range(len(self.header))]
        lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in cells]
        return "\n".join([self.title, *(line.rstrip() for line in lines)])

    def html(self) -> str:
        """A heading and a table."""
        return f"<p>{escape(self.title)}</p>{html_table(self.header, self.rows)}"


def html_table(columns: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """An HTML table, which scrolls where it is wider than the page; cells and column names are escaped.

    Args:
        columns: names of the columns.
        rows: one value for each column; floats are shown with three digits.
    """
    head = "".join(f"<th>{escape(name)}</th>" for name in columns)
    body = "".join(f"<tr>{''.join(f'<td>{_cell(value)}</td>' for value in row)}</tr>" for row in rows)
    return f'<div style="overflow-x:auto"><table><tr>{head}</tr>{body}</table></div>'


def _cell(value: Any) -> str:
    return f"{value:.3g}" if isinstance(value, float) else escape(str(value))


def data_frame(rows: list[dict[str, Any]]) -> Any:
    """A DataFrame if pandas is installed, else the rows unchanged."""
    try:
        from pandas import DataFrame  # pyright: ignore[reportMissingImports] (optional, not a dependency)
    except ImportError:
        return rows
    return DataFrame(rows)
