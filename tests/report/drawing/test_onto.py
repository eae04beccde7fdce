"""Figures drawn into the place of a caller's axes."""

import pytest
from matplotlib.figure import Figure

from estexp_jax.errors import InputError
from estexp_jax.report.drawing.onto import new_figure, picture_of


def test_without_axes_a_figure_has_its_own_size() -> None:
    assert picture_of(lambda: new_figure(3.0, 2.0)).figure.get_size_inches().tolist() == [3.0, 2.0]


def test_axes_are_replaced_and_what_comes_later_stands_alone() -> None:
    whole = Figure()
    axes = whole.subplots()
    assert picture_of(lambda: new_figure(3.0, 2.0), axes).figure is whole
    assert axes not in whole.axes and len(whole.subfigs) == 1
    assert isinstance(new_figure(1.0, 1.0), Figure)


@pytest.mark.parametrize("ax", [3, Figure().add_axes((0.0, 0.0, 1.0, 1.0))])
def test_what_has_no_place_in_a_grid_is_refused(ax: object) -> None:
    with pytest.raises(InputError, match="axes of a grid"):
        picture_of(lambda: new_figure(1.0, 1.0), ax)
