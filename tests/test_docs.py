"""The documentation: its examples run, what it names is there, and Sphinx builds it without a warning."""

import importlib
import importlib.util
import re
import shlex
import shutil
import subprocess
import sys
from textwrap import indent

import pytest

from estexp_jax.cli import commands
from estexp_jax.package_data import model_path
from estexp_jax.physics.effects import registry
from estexp_jax.physics.effects.changes import parse_change
from estexp_jax.physics.model.actuators import HAS_DECLARED_INPUTS
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recordings.columns import UNITS
from tests.conftest import ROOT

DOCS = ROOT / "docs"
PAGES = sorted(path.name for path in DOCS.glob("*.md"))
OF_EACH_COMMAND = ("files.py", "page.py", "result.py", "run.py", "text.py")
"""Names that files have in several folders: a table may tell them without one."""
RUN_ELSEWHERE = ["recovering.md"]
"""Its program drives a robot in `tests/api/test_recover.py`."""
WITH_EXAMPLES = ["effects.md", "engines.md", "faq.md", "recordings.md", "report.md"]


def blocks(page: str) -> list[str]:
    return re.findall(r"^```python\n(.*?)^```$", (DOCS / page).read_text(encoding="utf-8"), re.S | re.M)


def test_every_page_with_examples_is_run():
    assert [page for page in PAGES if blocks(page)] == sorted(WITH_EXAMPLES + RUN_ELSEWHERE)


@pytest.mark.parametrize("page", WITH_EXAMPLES)
def test_examples_run_one_after_another(page, tmp_path, monkeypatch, request):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(registry, "_EFFECTS", dict(registry._EFFECTS))  # an example registers an effect
    if page in ("faq.md", "report.md"):
        shutil.copytree(request.getfixturevalue("explained"), tmp_path / "explain")
    script = "\n".join(blocks(page))
    assert "assert " in script
    (tmp_path / "example.py").write_text(script, encoding="utf-8")
    spec = importlib.util.spec_from_file_location("example", tmp_path / "example.py")
    assert spec is not None and spec.loader is not None
    spec.loader.exec_module(importlib.util.module_from_spec(spec))


@pytest.mark.slow
def test_the_readmes_program_runs(recorded, tmp_path, monkeypatch):
    import matplotlib.pyplot as plt
    import pandas as pd

    monkeypatch.chdir(tmp_path)
    (tmp_path / "models").symlink_to(ROOT / "models")
    for name, own in (("nominal.xml", "nominal.xml"), ("train_0.csv", "a.csv"), ("test_0.csv", "c.csv")):
        shutil.copy(recorded / name, tmp_path / own)
    [program] = re.findall(r"^```python\n(.*?)^```$", (ROOT / "README.md").read_text(encoding="utf-8"), re.S | re.M)
    (tmp_path / "example.py").write_text(f"def run(frame, ax):\n{indent(program, '    ')}    return locals()\n")
    spec = importlib.util.spec_from_file_location("example", tmp_path / "example.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    made = module.run(pd.read_csv(recorded / "train_1.csv"), plt.subplots()[1])
    assert made["diagnosis"].verdict == "missing_physics" and "time" in made["traces"]
    assert (tmp_path / "out" / "report.html").is_file()


COMMAND_LINES = [
    (page, line.partition("  #")[0].strip())
    for page in ["../README.md", *PAGES]
    for block in re.findall(r"^```sh\n(.*?)^```$", (DOCS / page).read_text(encoding="utf-8"), re.S | re.M)
    for line in block.replace("\\\n", " ").splitlines()
    if line.startswith("estexp ")
]


def test_commands_that_pages_show_are_understood():
    assert len(COMMAND_LINES) >= 50
    for page, line in COMMAND_LINES:
        try:
            commands._parsed(shlex.split(line)[1:])
        except SystemExit as end:
            raise AssertionError(f"{page}: {line}") from end


@pytest.mark.parametrize("page", PAGES)
def test_files_and_units_that_pages_name_exist(page):
    text = (DOCS / page).read_text(encoding="utf-8")
    for path in re.findall(r"`((?:estexp_jax|models|tests|experiments)/[\w/.]+)`", text):
        assert (ROOT / path).exists(), path
    for path in re.findall(r"`((?:engines|effects)/test_\w+\.py)`", text):
        assert (ROOT / "tests" / "physics" / path).exists(), path
    if page == "recordings.md":
        assert all(f"`{unit}`" in text for unit in UNITS)


def test_bounds_are_those_of_the_code():
    text = (DOCS / "trust.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| .* \| ([\d,]+) \| `estexp_jax/([\w/]+)\.py`, `(\w+)` \|$", text, re.M)
    assert len(rows) >= 30
    for told, path, name in rows:
        bound = getattr(importlib.import_module(f"estexp_jax.{path.replace('/', '.')}"), name)
        assert f"{bound:,}" == told, (path, name)


@pytest.mark.parametrize(("page", "fewest"), [("architecture.md", 200), ("deciding.md", 5)])
def test_files_that_pages_name_by_room_and_what_stands_in_them_exist(page, fewest):
    _, _, text = (DOCS / page).read_text(encoding="utf-8").partition("\n## ")
    named = re.findall(r"`(\.?\w[\w./]*/[\w./]*|\w+\.py|\w+\.md)`((?:, `\w+`)*)", text)
    assert len(named) >= fewest
    for path, names in named:
        file = next((f for f in (ROOT / "estexp_jax" / path, ROOT / path) if f.exists()), None)
        assert file is not None or path in OF_EACH_COMMAND, path
        for name in re.findall(r"\w+", names):
            assert file is not None and re.search(rf"\b{name}\b", file.read_text(encoding="utf-8")), (path, name)


def test_the_page_of_effects_is_that_of_the_registry_and_its_examples_can_be_planted(monkeypatch):
    monkeypatch.setattr(registry, "_EFFECTS", {n: e for n, e in registry._EFFECTS.items() if e not in registry.own()})
    spec = importlib.util.spec_from_file_location("generate_effects", DOCS / "generate_effects.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    page = (DOCS / "effects_reference.md").read_text(encoding="utf-8")
    of_version = "" if HAS_DECLARED_INPUTS else "- In MJCF: "  # elements are those of MuJoCo 4
    written, kept = (
        [line for line in text.splitlines() if not of_version or not line.startswith(of_version)]
        for text in (module.reference(), page)
    )
    assert written == kept, "run: python docs/generate_effects.py"
    planted = re.findall(r'models/(\w+)\.xml --effect "(.*)"', page)
    robots = {name: Robot.from_xml(model_path(name)) for name in ("leg", "quadruped")}
    assert len(planted) >= 40
    for robot, text in planted:
        parse_change(text, robots[robot])
    assert sorted(re.findall(r"signatures/(\w+)\.svg", page)) == sorted(p.stem for p in (DOCS / "signatures").glob("*"))
    assert len(re.findall("signatures/", page)) >= 36  # python docs/draw_effects.py


@pytest.mark.slow
def test_sphinx_builds_it_without_a_warning(tmp_path):
    if any(importlib.util.find_spec(name) is None for name in ("sphinx", "furo", "myst_nb")):
        pytest.skip("no Sphinx; pip install 'estexp_jax[docs]'")
    shutil.copytree(DOCS, tmp_path / "docs", ignore=shutil.ignore_patterns("_api", "_build", "_notebooks"))
    (tmp_path / "experiments").symlink_to(ROOT / "experiments")
    command = [sys.executable, "-m", "sphinx", "-W", "-q", "-b", "html", str(tmp_path / "docs"), str(tmp_path / "html")]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    for notebook in (ROOT / "experiments" / "notebooks").glob("*.ipynb"):
        assert (tmp_path / "html" / "_notebooks" / f"{notebook.stem}.html").is_file()
    assert "CoulombFriction" in "".join(
        path.read_text(encoding="utf-8") for path in (tmp_path / "html" / "_api").glob("*coulomb*.html")
    )
