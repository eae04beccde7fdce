"""Errors of all models, without those that do not exist."""

from estexp_jax.report.explain.competing_models import figure_competing_models
from tests.report.examples import FINDINGS


def test_figure_rivals_shows_all_five_and_leaves_out_what_there_is_not():
    fit = {**FINDINGS["fit"], "black_box": {"train": 0.02, "test": None}, "explained": {"train": 0.0, "test": 0.003}}
    [axes] = figure_competing_models({**FINDINGS, "fit": fit}).axes
    labels = [label.get_text() for label in axes.get_yticklabels()]
    assert labels == [
        "nominal simulator", "parameters refitted", "black-box correction", "best wrong effect", "explained simulator",
    ]  # fmt: skip
    numbers = [text.get_text() for text in axes.texts]
    assert "4.44 %" in numbers and "0.3 %" in numbers and "no number" in numbers
    [axes] = figure_competing_models(FINDINGS).axes  # no black box
    assert len(axes.get_yticklabels()) == 4
