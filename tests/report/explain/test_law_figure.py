"""The figure of an unknown law: forces over position and speed, bounded where samples end."""

import numpy as np
import pytest

from estexp_jax.discovery.law_forces import LawForces
from estexp_jax.report.explain.law_figure import figure_law


@pytest.mark.parametrize(("unit", "force"), [("rad", "force (N m)"), ("m", "force (N)")])
def test_force_is_drawn_over_position_and_speed(unit, force):
    q = np.linspace(-1.0, 1.0, 300)
    figure = figure_law(LawForces("knee", q, np.cos(9.0 * q), 0.0 * q, q**3 + 0.01, q**3), unit)
    position, _, speed_density, _ = figure.axes[0], figure.axes[1], figure.axes[2], figure.axes[3]
    missing, law, low, high = position.get_lines()
    np.testing.assert_allclose(missing.get_ydata() - law.get_ydata(), 0.01)
    assert low.get_xdata()[0] == pytest.approx(-0.99) and high.get_xdata()[0] == pytest.approx(0.99)
    assert position.get_ylabel() == force and speed_density.get_xlabel() == f"q ({unit})"
