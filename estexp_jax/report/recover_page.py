"""The report of a recovery run: one HTML file that needs nothing else."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping, Sequence
from typing import Any

from estexp_jax.physics.changes import Change
from estexp_jax.recovery.state import RunState
from estexp_jax.report.film import source
from estexp_jax.report.recover_figure import path_figure, progress_figure
from estexp_jax.report.recover_film import Film

_TEMPLATE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>Recovery: {{ title }}</title>
<style>
body { font: 15px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; color: #222; }
table { border-collapse: collapse; margin: 1rem 0; } td, th { padding: .3rem .8rem; text-align: left; }
th { border-bottom: 2px solid #888; } td { border-bottom: 1px solid #ddd; vertical-align: top; }
td.number { text-align: right; font-variant-numeric: tabular-nums; } img { max-width: 100%; }
code { font-size: 85%; }
</style></head><body>
<h1>{{ title }}</h1>
<p>{{ headline }}</p>
<h2>What was wrong</h2>
<ul>{% for line in planted %}<li>{{ line }}</li>{% else %}<li>{{ nothing }}</li>{% endfor %}</ul>
<h2>What happened</h2>
<img alt="distance over generations" src="{{ progress }}">
<p>Dotted: the best controller in the simulator as diagnosed then. Triangle: the robot before the damage; circle: after
it; squares: its trials. Captions: the diagnoses.</p>
<table><tr><th>pass</th><th>diagnosis</th><th>probability</th><th>foretold (m)</th><th>trial (m)</th></tr>
{% for row in rows %}<tr><td>{{ row.number }}</td>
<td>{% for line in row.diagnosis %}{{ line }}<br>{% else %}nothing differs{% endfor %}</td>
<td class="number">{{ row.probability }}</td><td class="number">{{ row.simulated }}</td>
<td class="number">{{ row.hardware }}</td></tr>{% endfor %}</table>
<h2>The ways it went</h2>
<img alt="ways seen from above" src="{{ paths }}">
{% if strip %}<h2>How it walks</h2>
{% if video %}<video controls loop muted playsinline src="{{ video }}" style="max-width: 100%"></video>{% endif %}
<img alt="the walks in pictures" src="{{ strip }}">
<p>Orange: the parts that something has happened to. Below each picture: how far the robot has come, and when.</p>
{% endif %}
<h2>Settings</h2>
<table>{% for name, value in settings %}<tr><td>{{ name }}</td><td><code>{{ value }}</code></td></tr>
{% endfor %}</table>
</body></html>
"""


def page(
    title: str,
    planted: Sequence[Change],
    state: RunState,
    axis: str,
    settings: Mapping[str, Any],
    film: Film | None = None,
) -> str:
    """HTML of a run that has had its damage.

    Args:
        title: of the run.
        planted: what was wrong, where that is known.
        state: the run.
        axis: of the distance.
        settings: names to values, for the record.
        film: how it walks, where it could be drawn.
    """
    import jinja2

    template = jinja2.Environment(autoescape=True).from_string(_TEMPLATE)
    return template.render(
        title=title,
        headline=headline(state, axis),
        planted=[change.sentence() for change in planted],
        nothing="nothing was planted",
        progress=_image(progress_figure(state, axis)),
        paths=_image(path_figure(state, axis)),
        rows=table(state, axis),
        strip="" if film is None else source(film.strip, "image/jpeg"),
        video="" if film is None or film.video is None else source(film.video, "video/mp4"),
        settings=list(settings.items()),
    )


def headline(state: RunState, axis: str) -> str:
    """The run in one sentence."""
    if state.before is None:
        return "The robot has not been damaged yet."
    text = f"The robot walked {state.before.distance(axis):.2f} m before the damage"
    text += f" and {state.trials[0].distance(axis):.2f} m after it"
    return f"{text}; its last trial came {state.trials[-1].distance(axis):.2f} m." if state.trials[1:] else f"{text}."


def table(state: RunState, axis: str) -> list[dict[str, Any]]:
    """A row for each pass, as texts."""
    return [
        {
            "number": number,
            "diagnosis": [change.sentence() for change in each.diagnosis],
            "probability": "" if each.probability is None else f"{each.probability:.2f}",
            "simulated": f"{each.simulated:.2f}",
            "hardware": f"{each.hardware:.2f}",
        }
        for number, each in enumerate(state.passes(axis), start=1)
    ]


def _image(figure: Any) -> str:
    """A figure as the source of an <img>."""
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=130)
    return f"data:image/png;base64,{base64.b64encode(stream.getvalue()).decode()}"
