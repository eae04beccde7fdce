"""The tree of experiments: every study has a page and stands in the table, links lead somewhere, and it stays small."""

import re
import subprocess

import pytest

from estexp_jax.cli.experiment import studies
from tests.conftest import ROOT

EXPERIMENTS = ROOT / "experiments"
_MOST_BYTES = 5_000_000
_LINK = re.compile(r"\]\((?!https?:|#)([^)#\s]+)")
_NAME = re.compile(r"(?<![\w/])experiments/[\w/.]*\w")
_WITHOUT_PAGE = ("pictures",)


def test_every_study_has_a_page_and_stands_in_the_table() -> None:
    table = (EXPERIMENTS / "README.md").read_text(encoding="utf-8")
    for name, folder in studies(EXPERIMENTS).items():
        assert f"| [{name}](" in table and f"`estexp experiment {folder.name}`" in table, name
        assert (folder / "README.md").is_file() or name in _WITHOUT_PAGE, name


@pytest.mark.parametrize("page", ["README.md", "CHANGELOG.md", "experiments"])
def test_links_lead_somewhere(page: str) -> None:
    path = ROOT / page
    pages = [path] if path.is_file() else sorted(path.rglob("*.md"))
    broken = [
        f"{each.relative_to(ROOT)}: {link}"
        for each in pages
        for link in _LINK.findall(each.read_text(encoding="utf-8"))
        if not (each.parent / link).exists()
    ]
    assert not broken


@pytest.mark.parametrize("page", ["README.md", "CHANGELOG.md", "experiments"])
def test_programs_and_folders_that_pages_name_exist(page: str) -> None:
    path = ROOT / page
    pages = [path] if path.is_file() else sorted(path.rglob("*.md"))
    named = {name.partition("/STUDY")[0] for each in pages for name in _NAME.findall(each.read_text(encoding="utf-8"))}
    assert not sorted(name for name in named if not name.endswith("GROUP") and not (ROOT / name).exists())


def test_the_tree_stays_small() -> None:
    listed = subprocess.run(["git", "ls-files", "experiments"], cwd=ROOT, capture_output=True, text=True, check=False)
    if listed.returncode:
        pytest.skip("this is no repository")
    assert sum((ROOT / name).stat().st_size for name in listed.stdout.split()) < _MOST_BYTES
