"""The report of an explanation: one file, everything in it, nothing from elsewhere, for every verdict."""

import base64
import re
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

from estexp_jax.discovery.law_forces import LawForces
from estexp_jax.report.explain.competing_models import figure_competing_models
from estexp_jax.report.explain.figures import figure_fit, figure_ranking, figure_where, ranked, worst_channel
from estexp_jax.report.explain.page import explain_headline, explain_page
from tests.report.examples import FINDINGS, LONG, OTHERS, diagnosis


class Reader(HTMLParser):
    """Collects text, images and every address; notices tags that are not closed."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.addresses: list[str] = []
        self.text = ""

    def handle_starttag(self, tag, attrs):
        if tag not in ("meta", "img", "br"):
            self.open.append(tag)
        self.addresses += [value or "" for key, value in attrs if key in ("src", "href")]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += "" if {"style", "script"} & set(self.open) else data


def read(verdict: str) -> tuple[str, Reader]:
    d = diagnosis(verdict)
    html, reader = explain_page(d, d.findings), Reader()
    reader.feed(html)
    assert reader.open == []
    return html, reader


@pytest.mark.parametrize("verdict", OTHERS)
def test_it_needs_nothing_else_and_its_figures_are_drawings(verdict):
    html, reader = read(verdict)
    assert len(reader.addresses) == 4
    for address in reader.addresses:
        head, _, body = address.partition(",")
        assert head == "data:image/svg+xml;base64"
        drawing = base64.b64decode(body).decode()
        assert ElementTree.fromstring(drawing).tag.endswith("svg")
        assert not re.search(r'(?:href|src)="(?!#|data:)', drawing)
    outside = re.sub(r'src="data:[^"]*"', "", html)
    assert not re.search(r"https?:|@import|url\(|<script .|<link", outside)
    assert outside.count("<script>") == 1


def test_an_unknown_law_is_drawn_beside_its_equation():
    d, way = diagnosis(), np.linspace(-1.0, 1.0, 300)
    laws = (LawForces(LONG, way, np.cos(9.0 * way), 0.0 * way, way**3 + 0.01, way**3),)
    d = replace(d, laws=laws, findings=d.findings | {"what": [d.findings["what"][0] | {"effect": "unknown_law"}]})
    reader = Reader()
    reader.feed(explain_page(d, d.findings))
    assert len(reader.addresses) == 5 and r"\tau = -T \operatorname{sign}(\omega)" in reader.text


def test_it_tells_the_finding_in_full():
    _, reader = read("missing_physics")
    text = " ".join(reader.text.split())
    for told in (
        "The simulator lacks physics: the joint resists motion with 1.02 N m, and 1 more.",
        "tau = -T sign(w) & more", "1.02", "0.97 to 1.08", "N m", "94 %", "MJCF has no place for it",
        "40 % <of> its load", "leaves out", f"load_dependent_friction@{LONG}",
        "91 %", "1e-09", "at reversals; from 1.5 s on in b <i>$\\x$.csv",
        "4.44 %", "best wrong effect", "93 % (90 % interval 90 % to 95 %)", "whole recordings",
        "its error is 4 % of the sensors' range; the explained simulator's is 4 %, that of noise alone 0 %",
        f"viscous friction @ {LONG} + gravity tilt", "< 1 %", "parameters only",
        "The nominal simulator takes steps of 2 ms, the others of 0.125 ms, the black-box correction 0.5 ms",
        "Record a motion with the motor off.", "ignored: <b>x</b>",
        "1.5 million robot steps; 61 s; seed 5.", "jax 0.9.2",
    ):  # fmt: skip
        assert told in text, told
    assert text.count("black-box correction") == 1  # its step; there is no row of it
    assert "nan" not in text.lower().replace("nominal", "")


def test_what_the_user_typed_is_text_and_not_markup():
    html, _ = read("missing_physics")
    assert "<i>" not in html and "<b>x" not in html and "legs <1>" not in html
    assert "b &lt;i&gt;$\\x$.csv" in html and "legs &lt;1&gt;.xml" in html


def test_what_stays_as_it_is_keeps_its_step():
    text = " ".join(read("unexplained")[1].text.split())
    assert "takes steps of 2 ms, and so does the explained one, the others of 0.125 ms" in text


@pytest.mark.parametrize("verdict", [v for v in OTHERS if v != "missing_physics"])
def test_other_verdicts_read_well(verdict):
    _, reader = read(verdict)
    text = " ".join(reader.text.split())
    assert explain_headline(diagnosis(verdict).findings) in text
    assert "None" not in text and "nan" not in text
    assert "leaves out" not in text
    assert ("90 % interval" in text) == (verdict != "consistent")
    assert {"consistent": "as good as noise", "parameters": "What is off", "unexplained": "no effect"}[verdict] in text


def test_the_sections_stand_in_order():
    html, _ = read("missing_physics")
    titles = re.findall(r"<h2>(.*?)</h2>", html)
    assert titles == [
        "What is missing", "Where the error is", "Before and after",
        "What else it could be", "What to record next", "What was read",
    ]  # fmt: skip


def test_figure_fit_shows_the_test_recordings_worst_channel_over_its_range():
    shown, channel = worst_channel(diagnosis())
    assert (shown.recording, shown.channels[channel]) == ("b <i>$\\x$.csv", "angle")  # 0.3 of 2 beats 2 of 200
    above, below = figure_fit(diagnosis()).axes
    recorded, nominal, explained = (np.asarray(line.get_ydata()) for line in above.get_lines()[:3])
    assert nominal - recorded == pytest.approx(below.get_lines()[0].get_ydata(), nan_ok=True)
    assert np.nanmax(np.abs(nominal - recorded)) == pytest.approx(0.3)
    assert np.nanmax(np.abs(explained - recorded)) == pytest.approx(0.01)
    assert np.isnan(recorded).sum() == 3  # the gap, and a break before each window but the first


def test_figure_ranking_highlights_the_chosen_one():
    d = diagnosis()
    names = [name for name, _ in ranked(d)]
    assert names[:2] == ["nominal simulator", "parameters only"]
    assert names[2:] == [
        f"coulomb friction @ {LONG} + load dependent friction @ {LONG}",
        f"coulomb friction @ {LONG}",
        "body mass @ trunk",
    ]
    [axes] = figure_ranking(d).axes
    bold = [label.get_text() for label in axes.get_yticklabels() if label.get_fontweight() == "bold"]
    assert len(bold) == 1 and "load" in bold[0]
    assert axes.get_xscale() == "log"


def test_figure_rivals_shows_all_five_and_leaves_out_what_there_is_not():
    fit = {**FINDINGS["fit"], "black_box": {"train": 0.02, "test": None}, "explained": {"train": 0.0, "test": 0.003}}
    [axes] = figure_competing_models({**FINDINGS, "fit": fit}).axes
    labels = [label.get_text() for label in axes.get_yticklabels()]
    assert labels == [
        "nominal simulator", "parameters refitted", "black-box correction", "best wrong effect", "explained simulator",
    ]  # fmt: skip
    numbers = [text.get_text() for text in axes.texts]
    assert "4.44 %" in numbers and "0.3 %" in numbers and "no number" in numbers
    [axes] = figure_competing_models(FINDINGS).axes  # no black box
    assert len(axes.get_yticklabels()) == 4


def test_many_long_names_fit():
    d = diagnosis()
    predictions = tuple(replace(p, recording=f"{k}_{'x' * 80}.csv") for k in range(30) for p in d.predictions)
    places = [{"kind": "joint", "name": f"{LONG}_{k}", "share": 0.05, "p_value": 0.01} for k in range(20)]
    crowded = replace(d, predictions=predictions, findings={**d.findings, "where": places})
    for figure in (figure_where(crowded), figure_fit(crowded), figure_ranking(crowded)):
        figure.draw_without_rendering()
        width, height = figure.get_size_inches() * figure.dpi
        assert height < 2.0 * width
        for axes in figure.axes:
            box = axes.get_tightbbox()
            assert box is not None
            assert box.x0 >= -1.0 and box.y0 >= -1.0 and box.x1 <= width + 1.0 and box.y1 <= height + 1.0
