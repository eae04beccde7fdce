"""The report of an explanation: one HTML file that needs nothing else, for screens, phones and paper."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from estexp_jax.discovery.diagnosis import Diagnosis
from estexp_jax.discovery.telling_laws import joint_unit
from estexp_jax.estimation.windows import FINER
from estexp_jax.physics.effects.laws.base import UNKNOWN_LAW
from estexp_jax.report.drawing.film import source
from estexp_jax.report.explain.competing_models import NAMES, figure_competing_models
from estexp_jax.report.explain.figures import figure_fit, figure_ranking, figure_where
from estexp_jax.report.explain.latex import latex
from estexp_jax.report.explain.law_figure import figure_law
from estexp_jax.report.explain.text import VERDICTS
from estexp_jax.report.pages import capital, finite, format_number, image, percent, probability, render_page

_NOTHING = {
    "consistent": "Nothing: the nominal simulator is as good as noise lets one see.",
    "parameters": "Several small errors of values that the model has, none of them worth a line of its own.",
    "missing_physics": "",
    "unexplained": "The error is located below, but no effect that the program knows removes enough of it to be named.",
}


def explain_page(
    diagnosis: Diagnosis, findings: Mapping[str, Any], *, ghosts: bytes | None = None, marked: bytes | None = None
) -> str:
    """HTML of an explanation.

    Args:
        diagnosis: with the arrays that figures need.
        findings: complete, as in `findings.json`.
        ghosts: the robots in one scene (JPEG), where they could be drawn.
        marked: the robot with the parts that are named (JPEG), where it could be drawn.
    """
    return render_page(
        "explain_page.html",
        model=Path(diagnosis.case.robot.source).name,
        verdict=findings["verdict"],
        headline=explain_headline(findings),
        proof=_agreement(findings["fit"]) if findings["verdict"] == "consistent" else _proof(findings["fit"]),
        claims=[_claim(entry, diagnosis) for entry in findings["what"]],
        nothing=_NOTHING[findings["verdict"]],
        left_out=[capital(f"{c.sentence()} ({c.place})") for c in diagnosis.left_out] if findings["what"] else [],
        places=[_place(entry) for entry in findings["where"]],
        when=_when(findings["when"]) if findings["what"] else "",
        errors=_errors(findings["fit"]),
        gain=_gain(findings["fit"], told=findings["verdict"] != "consistent"),
        steps=_steps(diagnosis),
        alternatives=_alternatives(findings),
        advice=findings["advice"],
        data=[{**entry, "hz": format_number(entry["hz"])} for entry in findings["data"]],
        cost=_cost(findings),
        versions=sorted(findings["versions"].items()),
        where=image(figure_where(diagnosis)),
        fit=image(figure_fit(diagnosis)),
        rivals=image(figure_competing_models(findings)),
        ranking=image(figure_ranking(diagnosis)),
        ghosts="" if ghosts is None else source(ghosts, "image/jpeg"),
        marked="" if marked is None else source(marked, "image/jpeg"),
    )


def explain_headline(findings: Mapping[str, Any]) -> str:
    """The verdict in a sentence, with the first claim where physics is missing."""
    text = VERDICTS[findings["verdict"]]
    if findings["verdict"] != "missing_physics" or not findings["what"]:
        return text
    first, *others = findings["what"]
    more = f", and {len(others)} more" if others else ""
    return f"{text.removesuffix('.')}: {first['sentence']}{more}."


def _claim(entry: Mapping[str, Any], diagnosis: Diagnosis) -> dict[str, Any]:
    laws = [law for law in diagnosis.laws if entry["effect"] == UNKNOWN_LAW and law.joint == entry["name"]]
    numbers = [
        {"name": name, "unit": p["unit"], **{key: format_number(p[key]) for key in ("value", "low", "high")}}
        for name, p in entry["parameters"].items()
    ]
    return {
        "sentence": capital(entry["sentence"]),
        "equation": entry["equation"],
        "latex": latex(entry["equation"]),
        "law": image(figure_law(laws[0], joint_unit(diagnosis.case.robot, laws[0].joint))) if laws else "",
        "parameters": numbers,
        "place": capital(f"{entry['effect'].replace('_', ' ')}, {_named(entry)}"),
        "probability": probability(entry["probability"]),
        "in_mjcf": entry["in_mjcf"],
    }


def _place(entry: Mapping[str, Any]) -> dict[str, str]:
    return {"place": _named(entry), "share": percent(entry["share"], 0), "p_value": format_number(entry["p_value"], 2)}


def _named(entry: Mapping[str, Any]) -> str:
    return entry["kind"] if entry["name"] is None else f"{entry['kind']} {entry['name']}"


def _when(when: Mapping[str, Any]) -> str:
    late = [
        f"from {format_number(onset)} s on in {file}" for file, onset in when["onset_s"].items() if onset is not None
    ]
    return "; ".join([*([when["regime"]] if when["regime"] else []), *late])


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
    return f"On recordings that nothing was fitted to, its error is {error} of the sensors' range."


def _proof(fit: Mapping[str, Any]) -> str:
    """How much better unseen recordings are predicted, beside what noise alone leaves."""
    before, after, floor = (percent(fit[key]["test"]) for key in ("nominal", "explained", "noise_floor"))
    told = f"On recordings that nothing was fitted to, its error is {before} of the sensors' range"
    gain = fit["gain"]["value"]
    gone = f": {percent(gain, 0)} of what exceeds noise is gone" if finite(gain) else ""
    return f"{told}; the explained simulator's is {after}, that of noise alone {floor}{gone}."


def _steps(diagnosis: Diagnosis) -> str:
    """At which steps the simulators ran."""
    own = 1e3 * float(diagnosis.case.robot.model.opt.timestep)
    finest = {finer: f"{format_number(own / finer)} ms" for finer in (diagnosis.rivals_finer, FINER)}
    black_box = f", the black-box correction {finest[FINER]}" if len(finest) > 1 else ""
    alike = ", and so does the explained one" if diagnosis.finer < diagnosis.rivals_finer else ""
    nominal, others = f"{format_number(own)} ms{alike}", f"{finest[diagnosis.rivals_finer]}{black_box}"
    told = f"The nominal simulator takes steps of {nominal}, the others of {others}"
    return f"{told}: so fine that noise hides what they cost, or as fine as pays."


def _gain(fit: Mapping[str, Any], *, told: bool) -> str:
    windows = "whole recordings" if not finite(fit["window_s"]) else f"windows of {format_number(fit['window_s'])} s"
    measure = f"Root mean square over sensors and recordings, simulated in {windows}, each from a state estimated anew."
    gain = fit["gain"]
    if not (told and finite(gain["value"])):
        return measure
    gone = percent(gain["value"], 0)
    if finite(gain["low"]):
        gone += f" (90 % interval {percent(gain['low'], 0)} to {percent(gain['high'], 0)})"
    return f"{measure} Of the nominal simulator's test error above noise, {gone} is gone."


def _alternatives(findings: Mapping[str, Any]) -> list[dict[str, str]]:
    """Each other explanation once, the most probable form of it: several forms of an effect have one name."""
    claimed = {e["effect"] if e["name"] is None else f"{e['effect']}@{e['name']}" for e in findings["what"]}
    others: dict[str, dict[str, str]] = {}
    for entry in findings["alternatives"]:
        if not claimed or set(entry["effects"]) != claimed:
            told = _alternative(entry)
            others.setdefault(told["label"], told)
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
    return f"{'; '.join(parts)}; seed {findings['seed']}."
