"""Figures drawn into axes of the caller's own."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

from estexp_jax.errors import InputError
from estexp_jax.report.drawing.picture import Picture

_CANVAS: ContextVar[Any] = ContextVar("canvas", default=None)


def new_figure(width: float, height: float) -> Any:
    """A figure of a size in inches; inside `drawn_onto`, the part of the caller's figure where the axes were."""
    from matplotlib.figure import Figure

    canvas = _CANVAS.get()
    return Figure(figsize=(width, height), layout="constrained") if canvas is None else canvas


@contextmanager
def drawn_onto(ax: Any) -> Iterator[None]:
    """Let `new_figure` give the place of some axes, which are taken away; with None nothing changes.

    Raises:
        InputError: they are no axes of a grid.
    """
    if ax is None:
        yield
        return
    place = getattr(ax, "get_subplotspec", lambda: None)()
    if place is None:
        raise InputError("are no axes of a grid", where="ax", right="axes from plt.subplots() or figure.add_subplot()")
    parent = ax.figure
    ax.remove()
    token = _CANVAS.set(parent.add_subfigure(place))
    try:
        yield
    finally:
        _CANVAS.reset(token)


def picture_of(draw: Callable[[], Any], ax: Any = None) -> Picture:
    """A figure as a picture; with `ax` the caller's whole figure, in which it stands where those axes were.

    Raises:
        InputError: see `drawn_onto`.
    """
    whole = None if ax is None else getattr(ax, "figure", None)
    with drawn_onto(ax):
        figure = draw()
    return Picture(figure if whole is None else whole)
