"""The figure of an unknown law: forces over position and speed, bounded where samples end."""

import numpy as np
import pytest

from estexp_jax.discovery.law_forces import LawForces
from estexp_jax.report.explain.law_figure import figure_law


@pytest.mark.parametrize(("unit", "force"), [("rad", "force (N m)"), ("m", "force (N)")])
def test_force_is_drawn_over_position_and_speed(unit, force):
    q = np.linspace(-1.0, 1.0, 300)
    figure = figure_law(LawForces("knee", q, np.cos(9.0 * q), 0.0 * q, q**3 + 0.01, q**3), unit)
    position, _, position_density, _ = figure.axes
    missing, law = (np.asarray(line.get_ydata()) for line in position.get_lines()[:2])
    np.testing.assert_allclose(missing - law, 0.01)
    low, high = (float(np.asarray(line.get_xdata())[0]) for line in position.get_lines()[2:])
    assert (low, high) == pytest.approx((-0.99, 0.99))
    assert position.get_ylabel() == force and position_density.get_xlabel() == f"q ({unit})"
