"""Captions and legends of the figures of a run."""

import io
from dataclasses import replace

import pytest

from estexp_jax.recovery.state import RunState
from estexp_jax.report.recover.figure import _captions, path_figure
from tests.report.examples import WEAK, recovered


@pytest.fixture
def state() -> RunState:
    return recovered()


def test_captions_say_once_what_stays() -> None:
    captions = _captions(((WEAK,), (WEAK,), ()), 17)
    assert captions == ["1:\nthe motor knee_f\nlost 48 % of its\nstrength", "2: as before", "3:\nnothing differs"]
    assert _captions(((WEAK,), ()), 5) == ["1", "2"]


@pytest.mark.parametrize("stands_in", [False, True])
def test_the_legend_of_the_ways_is_inside_the_picture(state: RunState, stands_in: bool) -> None:
    far = [replace(t, position=100.0 * t.position) for t in state.trials]
    figure = path_figure(replace(state, before=far[1], trials=far), "x", stands_in=stands_in)
    figure.savefig(io.BytesIO(), dpi=100)
    (legend,) = figure.legends
    assert len(legend.get_texts()) == 3
    box = legend.get_window_extent()
    assert box.x0 >= 0.0 and box.x1 <= figure.bbox.x1
