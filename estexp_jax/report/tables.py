"""Rows for people: as a DataFrame where pandas is, as text and as HTML everywhere."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any, NamedTuple


class TextTable(NamedTuple):
    """A table of texts."""

    title: str
    header: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]

    def text(self) -> str:
        """The title, and one line a row, its columns one below the other."""
        cells = [self.header, *self.rows]
        widths = [max(len(row[i]) for row in cells) for i in range(len(self.header))]
        lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in cells]
        return "\n".join([self.title, *(line.rstrip() for line in lines)])

    def html(self) -> str:
        """A heading and a table."""
        head = "".join(f"<th>{escape(name)}</th>" for name in self.header)
        rows = ("".join(f"<td>{escape(cell)}</td>" for cell in row) for row in self.rows)
        body = "".join(f"<tr>{row}</tr>" for row in rows)
        return f"<p>{escape(self.title)}</p><table><tr>{head}</tr>{body}</table>"


def data_frame(rows: list[dict[str, Any]]) -> Any:
    """A DataFrame where pandas is present, else the rows as they are."""
    try:
        from pandas import DataFrame  # pyright: ignore[reportMissingImports] (a guest, not a dependency)
    except ImportError:
        return rows
    return DataFrame(rows)
