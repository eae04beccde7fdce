"""The commands, and the predictions of all explanations."""

import numpy as np

from estexp_jax.report.propose.figures import figure_commands, figure_predictions, informative_readings
from tests.report.examples import proposal


def test_figures_show_the_commands_and_all_rivals_where_they_differ_most():
    [axes] = figure_predictions(proposal()).axes
    assert [line.get_label() for line in axes.get_lines()[:3]] == ["1", "2", "3"]
    assert axes.get_ylabel() == "<i>angle</i>$\\x$ (rad)"
    assert informative_readings(proposal()) == {"<i>angle</i>$\\x$": [1.99, 0.01]}
    [motor] = figure_commands(proposal()).axes
    assert motor.get_title(loc="left") == "servo" and np.size(motor.get_lines()[0].get_xdata()) == 200
