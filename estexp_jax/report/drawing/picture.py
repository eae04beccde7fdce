"""Figures for notebooks."""

from __future__ import annotations

import io
from typing import Any, final


@final
class Picture:
    """A figure that shows itself in a notebook.

    Attributes:
        figure: matplotlib's.
    """

    def __init__(self, figure: Any) -> None:
        self.figure = figure

    def _repr_png_(self) -> bytes:
        stream = io.BytesIO()
        self.figure.savefig(stream, format="png", dpi=100)
        return stream.getvalue()

    def save(self, path: str) -> None:
        """Write the figure; the extension selects the format."""
        self.figure.savefig(path)
