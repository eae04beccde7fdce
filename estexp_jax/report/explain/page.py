"""The report of an explanation as one HTML file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from estexp_jax.discovery.clock_doubt import clock_lines
from estexp_jax.discovery.law_findings import joint_unit
from estexp_jax.discovery.regime import THROUGHOUT
from estexp_jax.estimation.windows import FINER
from estexp_jax.physics.effects.laws.base import UNKNOWN_LAW
from estexp_jax.report.drawing.film import source
from estexp_jax.report.explain.competing_models import NAMES, figure_competing_models
from estexp_jax.report.explain.figures import figure_fit, figure_ranking, figure_where
from estexp_jax.report.explain.latex import latex
from estexp_jax.report.explain.law_figure import figure_law
from estexp_jax.report.explain.marked import claimed_places
from estexp_jax.report.explain.next_steps import files_beside, next_commands, settled
from estexp_jax.report.explain.text import is_change, place_name, verdict_sentence
from estexp_jax.report.explain.traces import traces, traces_script, traces_style
from estexp_jax.report.pages import capital, finite, format_number, image, percent, probability, render_page

if TYPE_CHECKING:
    from estexp_jax.discovery.diagnosis import Diagnosis

_NOTHING = {
    "consistent": "Nothing: the nominal simulator is as good as noise allows to tell.",
    "parameters": "Several small errors in values of the model, none of them large enough to be listed.",
    "missing_physics": "",
    "unexplained": "The error is located below, but no effect of the catalogue removes enough of it to be reported.",
}


def explain_page(
    diagnosis: Diagnosis,
    findings: Mapping[str, Any],
    *,
    ghosts: tuple[bytes, str] | None = None,
    marked: bytes | None = None,
    folder: Path | None = None,
) -> str:
    """HTML of an explanation.

    Args:
        diagnosis: with the arrays for the figures.
        findings: as in `findings.json`.
        ghosts: the robots in one scene (JPEG), and where they are from; None: not drawn.
        marked: the robot with the claimed parts (JPEG); None: not drawn.
        folder: where the page's other files lie, all of them written; None: they are not named.
    """
    return render_page(
        "explain/page.html",
        more_script=traces_script(),
        more_style=traces_style(),
        traces=traces(diagnosis),
        what_heading=_what_heading(findings),
        files=files_beside(folder),
        commands=next_commands(folder, findings),
        settled=settled(findings),
        model=Path(diagnosis.case.robot.source).name,
        verdict=findings["verdict"],
        headline=explain_headline(findings),
        clocks=clock_lines(diagnosis.case.recordings),
        proof=_agreement(findings["fit"]) if findings["verdict"] == "consistent" else _proof(findings["fit"]),
        claims=[_claim(entry, diagnosis) for entry in findings["what"]],
        is_change=is_change(findings),
        baseline=[_claim(entry, diagnosis) for entry in findings.get("baseline", ())],
        discrepancy=[f"{name}: {format_number(size)}" for name, size in findings.get("discrepancy", {}).items()],
        nothing=_nothing(findings),
        left_out=[capital(f"{c.sentence()} ({c.place}): {why}") for c, why in diagnosis.native.left_out]
        if findings["what"]
        else [],
        places=[_place(entry) for entry in findings["where"]],
        when=_when(findings["when"]) if findings["what"] else "",
        errors=_errors(findings["fit"]),
        gain=_gain(findings["fit"], with_share=findings["verdict"] != "consistent"),
        steps=_steps(diagnosis),
        alternatives=_alternatives(findings),
        advice=findings["advice"],
        data=[{**entry, "hz": format_number(entry["hz"])} for entry in findings["data"]],
        cost=_cost(findings),
        versions=sorted(findings["versions"].items()),
        where=image(figure_where(diagnosis)),
        fit=image(figure_fit(diagnosis)),
        competing=image(figure_competing_models(findings)),
        ranking=image(figure_ranking(diagnosis)),
        ghosts="" if ghosts is None else source(ghosts[0], "image/jpeg"),
        ghosts_from="" if ghosts is None else ghosts[1],
        marked_places=", ".join(place_name(kind, name) for kind, name in claimed_places(findings)),
        marked="" if marked is None else source(marked, "image/jpeg"),
    )


def _what_heading(findings: Mapping[str, Any]) -> str:
    if is_change(findings) and findings["what"]:
        return "What has changed"
    if findings["verdict"] == "missing_physics":
        return "What is missing"
    return "What is off" if findings["what"] else "What was found"


def _nothing(findings: Mapping[str, Any]) -> str:
    """What stands where there are no claims."""
    if findings["verdict"] == "consistent" and is_change(findings):
        return "Nothing: the simulator of the healthy robot is as good as noise allows to tell."
    return _NOTHING[findings["verdict"]]


def explain_headline(findings: Mapping[str, Any]) -> str:
    """The verdict in a sentence, with the first claim where physics is missing."""
    text = verdict_sentence(findings)
    if findings["verdict"] != "missing_physics" or not findings["what"]:
        return text
    first, *others = findings["what"]
    more = f", and {len(others)} more" if others else ""
    return f"{text.removesuffix('.')}: {first['sentence']}{more}."


def _claim(entry: Mapping[str, Any], diagnosis: Diagnosis) -> dict[str, Any]:
    laws = [law for law in diagnosis.laws if entry["effect"] == UNKNOWN_LAW and law.joint == entry["name"]]
    parameters = [
        {
            "name": name,
            "unit": p["unit"],
            **{key: format_number(p[key]) for key in ("value", "low", "high")},
            "was": format_number(p["from"]) if "from" in p else "",
        }
        for name, p in entry["parameters"].items()
    ]
    return {
        "sentence": capital(entry["sentence"]),
        "equation": entry["equation"],
        "latex": latex(entry["equation"]),
        "law": image(figure_law(laws[0], joint_unit(diagnosis.case.robot, laws[0].joint))) if laws else "",
        "parameters": parameters,
        "place": capital(f"{entry['effect'].replace('_', ' ')}, {_place_name(entry)}"),
        "probability": probability(entry["probability"]),
        "in_mjcf": entry["in_mjcf"],
    }


def _place(entry: Mapping[str, Any]) -> dict[str, str]:
    share, p_value = percent(entry["share"], 0), format_number(entry["p_value"], 2)
    return {"place": _place_name(entry), "share": share, "p_value": p_value}


def _place_name(entry: Mapping[str, Any]) -> str:
    return place_name(entry["kind"], entry["name"])


def _when(when: Mapping[str, Any]) -> str:
    onsets = [
        f"from {format_number(onset)} s on in {file}" for file, onset in when["onset_s"].items() if onset is not None
    ]
    return "; ".join([*([when["regime"]] if when["regime"] not in (None, THROUGHOUT) else []), *onsets])


def _errors(fit: Mapping[str, Any]) -> list[dict[str, Any]]:
    return [
        {
            "name": name,
            "train": percent(fit[key]["train"]),
            "test": percent(fit[key]["test"]),
            "chosen": key == "explained",
        }
        for key, name in NAMES.items()
        if fit[key]
    ]


def _agreement(fit: Mapping[str, Any]) -> str:
    error = percent(fit["nominal"]["test"])
    return f"On test recordings, which were not used for fitting, its error is {error} of the sensors' range."


def _proof(fit: Mapping[str, Any]) -> str:
    """How much better the test recordings are predicted, compared with noise alone."""
    before, after, floor = (percent(fit[key]["test"]) for key in ("nominal", "explained", "noise_floor"))
    start = f"On test recordings, which were not used for fitting, its error is {before} of the sensors' range"
    gain = fit["gain"]["value"]
    removed = f" The explanation removes {percent(gain, 0)} of the error above noise." if finite(gain) else ""
    return f"{start}. The explained simulator's error is {after}, that of noise alone {floor}.{removed}"


def _steps(diagnosis: Diagnosis) -> str:
    """The time steps of the simulators."""
    own = 1e3 * float(diagnosis.case.robot.model.opt.timestep)
    finest = {finer: f"{format_number(own / finer)} ms" for finer in (diagnosis.rivals_finer, FINER)}
    black_box = f", the black-box correction {finest[FINER]}" if len(finest) > 1 else ""
    alike = ", as does the explained one" if diagnosis.finer < diagnosis.rivals_finer else ""
    nominal, others = f"{format_number(own)} ms{alike}", f"{finest[diagnosis.rivals_finer]}{black_box}"
    sentence = f"The nominal simulator takes steps of {nominal}, the others of {others}"
    return f"{sentence}. Their numerical error is then below the noise, or finer steps do not reduce it."


def _gain(fit: Mapping[str, Any], *, with_share: bool) -> str:
    windows = "whole recordings" if not finite(fit["window_s"]) else f"windows of {format_number(fit['window_s'])} s"
    measure = f"Root mean square over sensors and recordings, simulated in {windows}, each from an estimated state."
    gain = fit["gain"]
    if not (with_share and finite(gain["value"])):
        return measure
    share = percent(gain["value"], 0)
    if finite(gain["low"]):
        share += f" (90 % interval {percent(gain['low'], 0)} to {percent(gain['high'], 0)})"
    return f"{measure} The explanation removes {share} of the nominal simulator's test error above noise."


def _alternatives(findings: Mapping[str, Any]) -> list[dict[str, str]]:
    """Each other explanation once, in its most probable form, since several forms of an effect have one name."""
    claimed = {e["effect"] if e["name"] is None else f"{e['effect']}@{e['name']}" for e in findings["what"]}
    others: dict[str, dict[str, str]] = {}
    for entry in findings["alternatives"]:
        if not claimed or set(entry["effects"]) != claimed:
            row = _alternative(entry)
            others.setdefault(row["label"], row)
    return list(others.values())


def _alternative(entry: Mapping[str, Any]) -> dict[str, str]:
    label = " + ".join(e.replace("@", " @ ").replace("_", " ", e.split("@")[0].count("_")) for e in entry["effects"])
    return {
        "label": label or "parameters only",
        "probability": probability(entry["probability"]),
        "error": percent(entry["test_error"]),
    }


def _cost(findings: Mapping[str, Any]) -> str:
    cost = findings["cost"]
    parts = [f"{cost['robot_steps'] / 1e6:.3g} million robot steps"]
    if finite(cost["wall_s"]):
        compiled = f", {cost['compile_s']:.0f} s of them compiling" if finite(cost["compile_s"]) else ""
        parts.append(f"{cost['wall_s']:.0f} s{compiled}")
    if "engine" in findings:
        parts.append(_engine(findings["engine"]))
    return f"{'; '.join(parts)}; seed {findings['seed']}."


def _engine(engine: Mapping[str, Any]) -> str:
    most = engine["largest_difference"]
    return f"engine {engine['name']}" + (f", within {most:.1g} of MuJoCo on this robot" if finite(most) else "")
