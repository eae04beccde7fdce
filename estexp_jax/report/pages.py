"""Rendering of report pages: single files without external parts, for screens, phones and paper.

Figures enlarge on a click, tables sort by their headings and commands can be copied, with the script of `page.js`. A
content security policy allows only a page's own script, by its hash, and data in the page. So names from a log can load
and run nothing, even if the templates did not escape them.
"""

from __future__ import annotations

import base64
import hashlib
import io
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from jinja2 import Environment
    from matplotlib.figure import Figure

_FOLDER = Path(__file__).parent


def render_page(template: str, *, more_script: str = "", more_style: str = "", **values: Any) -> str:
    """HTML of a page.

    Args:
        template: a file of this folder that extends `page.html`.
        more_script: what this page runs before `page.js`.
        more_style: style sheet before `page.css`.
        values: contents of the page; texts are escaped.
    """
    from markupsafe import Markup

    script, style = ((_FOLDER / name).read_text(encoding="utf-8") for name in ("page.js", "page.css"))
    script, style = f"{more_script}{script}", f"{more_style}{style}"
    shared = {"script": Markup(script), "style": Markup(style), "policy": policy(script)}
    return _environment().get_template(template).render(**shared, **values)


def policy(script: str) -> str:
    """The content security policy that allows one script and data in the page only."""
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    return (
        "default-src 'none'; img-src data:; media-src data:; style-src 'unsafe-inline'; "
        f"script-src 'sha256-{digest}'; base-uri 'none'; form-action 'none'"
    )


@lru_cache(maxsize=1)
def _environment() -> Environment:
    import jinja2

    return jinja2.Environment(loader=jinja2.FileSystemLoader(_FOLDER), autoescape=True, trim_blocks=True)


def image(figure: Figure) -> str:
    """A figure as the source of an <img>: SVG with letters as paths, so that no font is needed."""
    import matplotlib

    stream = io.BytesIO()
    with matplotlib.rc_context({"svg.fonttype": "path", "svg.hashsalt": "estexp"}):
        figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
    return f"data:image/svg+xml;base64,{base64.b64encode(stream.getvalue()).decode()}"


def finite(value: Any) -> bool:
    """Whether a value is a finite number."""
    return value is not None and bool(np.isfinite(value))


def format_number(value: Any, digits: int = 3) -> str:
    """A number with some digits; a text unchanged; a dash if there is no number."""
    if isinstance(value, str):
        return value
    return f"{value:.{digits}g}" if finite(value) else "–"


def percent(value: Any, digits: int | None = None) -> str:
    """A share in per cent with some digits after the point, by default three digits in all."""
    if not finite(value):
        return "–"
    return f"{100.0 * value:.3g} %" if digits is None else f"{100.0 * value:.{digits}f} %"


def metres(value: float) -> str:
    """A distance in a sentence; it may be unknown."""
    return f"{value:.2f} m" if finite(value) else "an unknown distance"


def probability(value: float) -> str:
    """A probability; never 0 or 100 %, since it comes from a limited number of resamples."""
    return "> 99 %" if value > 0.99 else "< 1 %" if value < 0.01 else percent(value, 0)


def capital(text: str) -> str:
    """A text with a capital first letter."""
    return text[:1].upper() + text[1:]
