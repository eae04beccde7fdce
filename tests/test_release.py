"""What is released: one version, a small archive, and workflows that call the commands of this repository."""

import re
import tomllib

from tests.conftest import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def test_the_version_stands_in_one_place_and_the_citation_follows() -> None:
    cited = re.search(r"^version: (.*)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.M)
    assert cited is not None and cited[1] == PROJECT["version"]
    own = [p for p in (ROOT / "estexp_jax").rglob("*.py") if f'"{PROJECT["version"]}"' in p.read_text(encoding="utf-8")]
    assert not own


def test_python_versions_that_are_promised_are_tried_by_the_workflows() -> None:
    said = {c.rpartition(" ")[2] for c in PROJECT["classifiers"] if re.search(r":: 3\.\d+$", c)}
    workflow = (ROOT / ".github" / "workflows" / "tests.yml").read_text(encoding="utf-8")
    assert said == set(re.findall(r'"(3\.\d+)"', workflow)) >= {"3.11", "3.13"}


def test_workflows_call_what_a_developer_calls() -> None:
    called = [
        line
        for path in (ROOT / ".github" / "workflows").glob("*.yml")
        for line in re.findall(r"- run: (.*)", path.read_text(encoding="utf-8"))
    ]
    targets = set(re.findall(r"^(\w+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.M))
    for line in called:
        command, *rest = line.split()
        assert command in ("uv", "test") or (command == "make" and rest[0] in targets) or (ROOT / command).is_file(), (
            line
        )


def test_the_archive_holds_code_and_pages_alone() -> None:
    """Under 1 MB: experiments, with their tables and pictures, stay out."""
    archive = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["hatch"]["build"]["targets"]
    parts = [ROOT / name.lstrip("/") for name in archive["sdist"]["include"]]
    assert all(part.exists() for part in parts) and ROOT / "experiments" not in parts
    files = [f for part in parts for f in ([part] if part.is_file() else part.rglob("*")) if f.is_file()]
    kept = [f for f in files if not {"__pycache__", "_api", "_notebooks"} & set(f.parts)]
    assert sum(f.stat().st_size for f in kept) < 4_000_000  # text, which packs to a fourth and less


def test_the_readme_is_short_and_its_links_lead_somewhere() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert 600 <= len(text.split()) <= 800
    for link in re.findall(r"\]\(([\w./-]+)\)", text):
        assert (ROOT / link).exists(), link
