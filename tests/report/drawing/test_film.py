"""Strips and films contain the given pictures."""

import io

import numpy as np
import pytest
from PIL import Image

from estexp_jax.report.drawing.film import can_film, captioned, film, strip


def test_strips_and_films_hold_what_they_were_given() -> None:
    grey = captioned(np.full((30, 40, 3), 90, np.uint8), "a line")
    assert grey.shape == (48, 40, 3) and grey[30:].min() < 128 < grey[30:].max()
    whole = np.asarray(Image.open(io.BytesIO(strip([[grey, grey], [grey, grey]]))))
    assert whole.shape == (96, 80, 3) and abs(int(whole[10, 10, 0]) - 90) < 4
    if not can_film():
        pytest.skip("no film without the extra `video`")
    content = film([grey] * 10, 10.0)
    assert content[4:8] == b"ftyp" and film([grey] * 10, 10.0) == content
