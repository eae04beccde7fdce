"""Strips of pictures with captions as JPEG, and films as MP4."""

from __future__ import annotations

import base64
import io
import subprocess
import tempfile
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

_QUALITY, _CAPTION = 82, 18
_MOST_BYTES = 2_000_000
_CRF = (26, 32, 38)
"""Compression of a film: the first that keeps it below `_MOST_BYTES`, else the last."""


def captioned(picture: np.ndarray, text: str) -> np.ndarray:
    """A picture (h, w, 3) with a line of text below it, (h + 18, w, 3)."""
    from PIL import Image, ImageDraw

    line = Image.new("RGB", (picture.shape[1], _CAPTION), (255, 255, 255))
    ImageDraw.Draw(line).text((4, 2), text, fill=(40, 40, 40), font=_font())
    return np.concatenate([picture, np.asarray(line)])


def strip(rows: Sequence[Sequence[np.ndarray]]) -> bytes:
    """Pictures of one size, rows below each other, as a JPEG."""
    from PIL import Image

    whole = np.concatenate([np.concatenate(list(row), axis=1) for row in rows])
    stream = io.BytesIO()
    Image.fromarray(whole).save(stream, "JPEG", quality=_QUALITY, optimize=True)
    return stream.getvalue()


def can_film() -> bool:
    """Whether the video encoder is installed."""
    try:
        import imageio_ffmpeg  # pyright: ignore[reportMissingImports]

        imageio_ffmpeg.get_ffmpeg_exe()
    except (ImportError, RuntimeError):
        return False
    return True


def film(pictures: Sequence[np.ndarray], fps: float) -> bytes:
    """A film as MP4 (H.264), up to 2 MB unless it is long; needs the extra `video`.

    Args:
        pictures: (h, w, 3) each; even numbers of pixels.
        fps: frames per second.
    """
    content = b""
    for crf in _CRF:
        content = _encoded(pictures, fps, crf)
        if len(content) <= _MOST_BYTES:
            break
    return content


def _encoded(pictures: Sequence[np.ndarray], fps: float, crf: int) -> bytes:
    import imageio_ffmpeg  # pyright: ignore[reportMissingImports]

    height, width = pictures[0].shape[:2]
    raw = f"-f rawvideo -pix_fmt rgb24 -s {width}x{height} -r {fps:.3f} -i -".split()
    made = f"-an -c:v libx264 -pix_fmt yuv420p -crf {crf} -preset slow -threads 1 -movflags +faststart".split()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "film.mp4"
        command = [imageio_ffmpeg.get_ffmpeg_exe(), "-v", "error", *raw, *made, str(path)]
        subprocess.run(command, input=b"".join(p.tobytes() for p in pictures), check=True, capture_output=True)
        return path.read_bytes()


def source(content: bytes, kind: str) -> str:
    """The source of an <img> or <video>: `kind` is image/jpeg or video/mp4."""
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"


@lru_cache(maxsize=1)
def _font() -> Any:
    from matplotlib import get_data_path
    from PIL import ImageFont

    return ImageFont.truetype(str(Path(get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf"), 12)
