"""Figures of an explanation: worst channel, ranking, and many long names."""

from dataclasses import replace

import numpy as np
import pytest

from estexp_jax.report.explain.figures import figure_fit, figure_ranking, figure_where, ranked, worst_channel
from tests.report.examples import LONG, diagnosis


def test_figure_fit_shows_the_test_recordings_worst_channel_over_its_range():
    shown, channel = worst_channel(diagnosis())
    assert (shown.recording, shown.channels[channel]) == ("b <i>$\\x$.csv", "angle")  # 0.3 of 2 beats 2 of 200
    above, below = figure_fit(diagnosis()).axes
    recorded, nominal, explained = (np.asarray(line.get_ydata()) for line in above.get_lines()[:3])
    assert nominal - recorded == pytest.approx(below.get_lines()[0].get_ydata(), nan_ok=True)
    assert np.nanmax(np.abs(nominal - recorded)) == pytest.approx(0.3)
    assert np.nanmax(np.abs(explained - recorded)) == pytest.approx(0.01)
    assert np.isnan(recorded).sum() == 3  # the gap, and a break before each window but the first


def test_figure_ranking_highlights_the_chosen_one():
    d = diagnosis()
    names = [name for name, _ in ranked(d)]
    assert names[:2] == ["nominal simulator", "parameters only"]
    assert names[2:] == [
        f"coulomb friction @ {LONG} + load dependent friction @ {LONG}",
        f"coulomb friction @ {LONG}",
        "body mass @ trunk",
    ]
    [axes] = figure_ranking(d).axes
    bold = [label.get_text() for label in axes.get_yticklabels() if label.get_fontweight() == "bold"]
    assert len(bold) == 1 and "load" in bold[0]
    assert axes.get_xscale() == "log"


def test_many_long_names_fit():
    d = diagnosis()
    predictions = tuple(replace(p, recording=f"{k}_{'x' * 80}.csv") for k in range(30) for p in d.predictions)
    places = [{"kind": "joint", "name": f"{LONG}_{k}", "share": 0.05, "p_value": 0.01} for k in range(20)]
    crowded = replace(d, predictions=predictions, findings={**d.findings, "where": places})
    for figure in (figure_where(crowded), figure_fit(crowded), figure_ranking(crowded)):
        figure.draw_without_rendering()
        width, height = figure.get_size_inches() * figure.dpi
        assert height < 2.0 * width
        for axes in figure.axes:
            box = axes.get_tightbbox()
            assert box is not None
            assert box.x0 >= -1.0 and box.y0 >= -1.0 and box.x1 <= width + 1.0 and box.y1 <= height + 1.0


def test_labels_of_the_ranking_do_not_overlap():
    figure = figure_ranking(diagnosis())
    figure.draw_without_rendering()
    boxes = [label.get_window_extent() for label in figure.axes[0].get_yticklabels()]
    assert all(upper.y0 > lower.y1 for upper, lower in zip(boxes, boxes[1:], strict=False))
