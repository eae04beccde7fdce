"""The report of an explanation: one HTML file that needs nothing else, for screens, phones and paper."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from estexp_jax.discovery.diagnosis import Diagnosis
from estexp_jax.report.explain_figures import figure_fit, figure_ranking, figure_where
from estexp_jax.report.explain_rivals import NAMES, figure_rivals
from estexp_jax.report.explain_text import VERDICTS, proof
from estexp_jax.report.film import source

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_TEMPLATE = Path(__file__).with_name("explain_page.html")
_NOTHING = {
    "consistent": "Nothing: the nominal simulator is as good as noise lets one see.",
    "parameters": "Several small errors of values that the model has, none of them worth a line of its own.",
    "missing_physics": "",
    "unexplained": "The error is located below, but no effect that the program knows removes enough of it to be named.",
}


def page(diagnosis: Diagnosis, findings: Mapping[str, Any], ghosts: bytes | None = None) -> str:
    """HTML of an explanation.

    Args:
        diagnosis: with the arrays that figures need.
        findings: complete, as in `findings.json`.
        ghosts: the robots in one scene (JPEG), where they could be drawn.
    """
    import jinja2

    template = jinja2.Environment(autoescape=True, trim_blocks=True).from_string(_TEMPLATE.read_text(encoding="utf-8"))
    return template.render(
        model=Path(diagnosis.case.robot.source).name,
        verdict=findings["verdict"],
        headline=headline(findings),
        proof=_agreement(findings["fit"]) if findings["verdict"] == "consistent" else proof(findings),
        claims=[_claim(entry) for entry in findings["what"]],
        nothing=_NOTHING[findings["verdict"]],
        left_out=[_capital(f"{c.sentence()} ({c.place})") for c in diagnosis.left_out] if findings["what"] else [],
        places=[_place(entry) for entry in findings["where"]],
        when=_when(findings["when"]) if findings["what"] else "",
        errors=_errors(findings["fit"]),
        gain=_gain(findings["fit"], told=findings["verdict"] != "consistent"),
        alternatives=[_alternative(entry) for entry in findings["alternatives"]],
        advice=findings["advice"],
        data=[{**entry, "hz": _number(entry["hz"])} for entry in findings["data"]],
        cost=_cost(findings),
        versions=sorted(findings["versions"].items()),
        where=_image(figure_where(diagnosis)),
        fit=_image(figure_fit(diagnosis)),
        rivals=_image(figure_rivals(findings)),
        ranking=_image(figure_ranking(diagnosis)),
        ghosts="" if ghosts is None else source(ghosts, "image/jpeg"),
    )


def headline(findings: Mapping[str, Any]) -> str:
    """The verdict in a sentence, with the first claim where physics is missing."""
    text = VERDICTS[findings["verdict"]]
    if findings["verdict"] != "missing_physics" or not findings["what"]:
        return text
    first, *others = findings["what"]
    more = f", and {len(others)} more" if others else ""
    return f"{text.removesuffix('.')}: {first['sentence']}{more}."


def _claim(entry: Mapping[str, Any]) -> dict[str, Any]:
    numbers = [
        {"name": name, "unit": p["unit"], **{key: _number(p[key]) for key in ("value", "low", "high")}}
        for name, p in entry["parameters"].items()
    ]
    return {
        "sentence": _capital(entry["sentence"]),
        "equation": entry["equation"],
        "parameters": numbers,
        "place": _capital(f"{entry['effect'].replace('_', ' ')}, {_named(entry)}"),
        "probability": _probability(entry["probability"]),
        "in_mjcf": entry["in_mjcf"],
    }


def _place(entry: Mapping[str, Any]) -> dict[str, str]:
    return {"place": _named(entry), "share": _percent(entry["share"], 0), "p_value": _number(entry["p_value"], 2)}


def _named(entry: Mapping[str, Any]) -> str:
    return entry["kind"] if entry["name"] is None else f"{entry['kind']} {entry['name']}"


def _when(when: Mapping[str, Any]) -> str:
    late = [f"from {_number(onset)} s on in {file}" for file, onset in when["onset_s"].items() if onset is not None]
    return "; ".join([*([when["regime"]] if when["regime"] else []), *late])


def _errors(fit: Mapping[str, Any]) -> list[dict[str, Any]]:
    return [
        {
            "name": name,
            "train": _percent(fit[key]["train"]),
            "test": _percent(fit[key]["test"]),
            "chosen": key == "explained",
        }
        for key, name in NAMES.items()
        if fit[key]
    ]


def _agreement(fit: Mapping[str, Any]) -> str:
    error = _percent(fit["nominal"]["test"])
    return f"On recordings that nothing was fitted to, its error is {error} of the sensors' range."


def _gain(fit: Mapping[str, Any], *, told: bool) -> str:
    windows = "whole recordings" if not _finite(fit["window_s"]) else f"windows of {_number(fit['window_s'])} s"
    measure = f"Root mean square over sensors and recordings, simulated in {windows}, each from a state estimated anew."
    gain = fit["gain"]
    if not (told and _finite(gain["value"])):
        return measure
    gone = _percent(gain["value"], 0)
    if _finite(gain["low"]):
        gone += f" (90 % interval {_percent(gain['low'], 0)} to {_percent(gain['high'], 0)})"
    return f"{measure} Of the nominal simulator's test error above noise, {gone} is gone."


def _alternative(entry: Mapping[str, Any]) -> dict[str, str]:
    label = " + ".join(e.replace("@", " @ ").replace("_", " ", e.split("@")[0].count("_")) for e in entry["effects"])
    return {
        "label": label or "parameters only",
        "probability": _probability(entry["probability"]),
        "error": _percent(entry["test_error"]),
    }


def _cost(findings: Mapping[str, Any]) -> str:
    cost = findings["cost"]
    parts = [f"{cost['robot_steps'] / 1e6:.3g} million robot steps"]
    if _finite(cost["wall_s"]):
        compiled = f", {cost['compile_s']:.0f} s of them compiling" if _finite(cost["compile_s"]) else ""
        parts.append(f"{cost['wall_s']:.0f} s{compiled}")
    return f"{'; '.join(parts)}; seed {findings['seed']}."


def _finite(value: Any) -> bool:
    return value is not None and bool(np.isfinite(value))


def _number(value: Any, digits: int = 3) -> str:
    if isinstance(value, str):
        return value
    return f"{value:.{digits}g}" if _finite(value) else "–"


def _percent(value: Any, digits: int | None = None) -> str:
    """A share in per cent, with so many digits after the point, or three in all."""
    if not _finite(value):
        return "–"
    return f"{100.0 * value:.3g} %" if digits is None else f"{100.0 * value:.{digits}f} %"


def _probability(value: float) -> str:
    """Never quite certain, never quite impossible: it comes from a limited number of resamples."""
    return "> 99 %" if value > 0.99 else "< 1 %" if value < 0.01 else _percent(value, 0)


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _image(figure: Figure) -> str:
    """A figure as the source of an <img>: SVG, letters drawn, so that no font is needed."""
    import matplotlib

    stream = io.BytesIO()
    with matplotlib.rc_context({"svg.fonttype": "path", "svg.hashsalt": "estexp"}):
        figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
    return f"data:image/svg+xml;base64,{base64.b64encode(stream.getvalue()).decode()}"
