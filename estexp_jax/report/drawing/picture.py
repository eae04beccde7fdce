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

    def __repr__(self) -> str:
        width, height = self.figure.get_size_inches()
        return f"Picture({width:.3g} x {height:.3g} inches); .save('NAME.png'), .figure"

    def _repr_png_(self) -> bytes:
        stream = io.BytesIO()
        self.figure.savefig(stream, format="png", dpi=100)
        return stream.getvalue()

    def save(self, path: str) -> None:
        """Write the figure; the extension selects the format."""
        self.figure.savefig(path)
