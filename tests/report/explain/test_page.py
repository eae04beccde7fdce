"""The report of an explanation: one file, everything in it, nothing from elsewhere, for every verdict."""

import base64
import re
import shlex
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

from estexp_jax.discovery.law_forces import LawForces
from estexp_jax.report.explain.page import explain_headline, explain_page
from estexp_jax.report.explain.traces import traces_script
from tests.report.examples import LONG, OTHERS, diagnosis


class Reader(HTMLParser):
    """Collects text, images and every address; notices tags that are not closed."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.addresses: list[str] = []
        self.links: list[str] = []
        self.text = ""

    def handle_starttag(self, tag, attrs):
        if tag not in ("meta", "img", "br"):
            self.open.append(tag)
        self.addresses += [value or "" for key, value in attrs if key == "src" or tag == "link"]
        self.links += [value or "" for key, value in attrs if key == "href"]

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
    outside = re.sub(r'src="data:[^"]*"', "", html).replace(traces_script(), "")
    assert not re.search(r"https?:|@import|url\(|<script [^t]|<link", outside)
    assert outside.count("<script") == 2 and '<script type="application/json"' in outside
    assert reader.links and all(link[0] == "#" and f'id="{link[1:]}"' in html for link in reader.links)


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
        "tau = -T sign(w) & more", "1.02", "0.97 to 1.08", "N m", "94 %", "MJCF cannot express it",
        "40 % <of> its load", "leaves out", f"load_dependent_friction@{LONG}",
        "91 %", "1e-09", "at reversals; from 1.5 s on in b <i>$\\x$.csv",
        "4.44 %", "best wrong effect", "93 % (90 % interval 90 % to 95 %)", "whole recordings",
        "its error is 4 % of the sensors' range. The explained simulator's error is 4 %, that of noise alone 0 %.",
        "The explanation removes 93 % of the error above noise.",
        f"viscous friction @ {LONG} + gravity tilt", "< 1 %", "parameters only",
        "The nominal simulator takes steps of 2 ms, the others of 0.125 ms, the black-box correction 0.5 ms",
        "Record a motion with the motor off.", "ignored: <b>x</b>",
        "1.5 million robot steps; 61 s; engine lanes, within 2e-06 of MuJoCo on this robot; seed 5.", "jax 0.9.2",
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
    assert "takes steps of 2 ms, as does the explained one, the others of 0.125 ms" in text


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
    titles = re.findall(r"<h2 id=\"\w+\">(.*?)</h2>", html)
    assert titles == [
        "What is missing", "Where the error is", "Before and after",
        "What else it could be", "What to record next", "Recordings",
    ]  # fmt: skip


def test_files_beside_it_are_linked_and_commands_name_their_folder(tmp_path):
    folder = tmp_path / "it's"
    folder.mkdir()
    for name in ("findings.json", "rivals.json"):
        (folder / name).touch()
    d, reader = diagnosis(), Reader()
    reader.feed(explain_page(d, d.findings, folder=folder))
    assert {link for link in reader.links if link[0] != "#"} == {"findings.json", "rivals.json"}
    assert f'ee.load_explained("{folder}")' in reader.text
    assert f"estexp propose {shlex.quote(str(folder))} --out" in reader.text


def test_when_is_told_only_where_it_says_something():
    d = diagnosis()
    always = {"regime": "throughout", "onset_s": {"a.csv": None}}
    assert "When:" in explain_page(d, d.findings) and "When:" not in explain_page(d, d.findings | {"when": always})


def test_settled_cases_say_that_nothing_more_needs_recording():
    d = diagnosis()
    assert "no further recording is needed" in explain_page(d, d.findings | {"advice": []})
