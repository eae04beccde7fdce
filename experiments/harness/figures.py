"""Figures as files, small enough to stand in the repository."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

from estexp_jax.runs.files import replacing

_COLOURS = 128
"""Of a published picture: lines, bars and letters need no more, and it takes a third of the space."""


def write_figure(path: Path, figure: Any, dpi: int = 110) -> None:
    """Write a figure as PNG with a palette, whole or not at all.

    Args:
        path: of the picture.
        figure: of matplotlib.
        dpi: dots an inch.
    """
    from PIL import Image

    drawn = io.BytesIO()
    figure.savefig(drawn, format="png", dpi=dpi, facecolor="white")
    with Image.open(drawn) as image, replacing(path) as stream:
        picture = image.convert("RGB").quantize(_COLOURS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
        picture.save(stream, format="PNG", optimize=True)
