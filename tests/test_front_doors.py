"""What the package offers at its top level, and the notebooks that show it."""

import subprocess
import sys
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

import estexp_jax as ee

NOTEBOOKS = sorted((Path(__file__).resolve().parents[1] / "experiments" / "notebooks").glob("*.ipynb"))


def test_every_door_opens():
    for name in ee.__all__:
        assert callable(getattr(ee, name))


def test_what_does_not_exist_is_told():
    with pytest.raises(AttributeError, match="no attribute 'repair'"):
        ee.repair  # noqa: B018


def test_importing_costs_nothing():
    code = "import sys, estexp_jax; assert not {'jax', 'mujoco', 'matplotlib'} & set(sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_there_are_notebooks_of_both_jobs_and_of_an_own_effect():
    assert [path.stem for path in NOTEBOOKS] == ["explain", "own_effect", "recover"]


@pytest.mark.filterwarnings("ignore")  # of Jupyter's own parts
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda p: p.stem)
def test_a_notebook_runs_and_shows_pictures(path, tmp_path):
    book = nbformat.read(path, as_version=4)
    NotebookClient(book, timeout=900, resources={"metadata": {"path": str(tmp_path)}}).execute()
    kinds = [kind for cell in book.cells for output in cell.get("outputs", ()) for kind in output.get("data", {})]
    assert sum(kind.startswith("image/") for kind in kinds) >= 2
    if path.stem == "recover":
        told = [output for cell in book.cells for output in cell.get("outputs", ())]
        filmed = any('alt="the walks"' in output.get("data", {}).get("text/html", "") for output in told)
        assert filmed or any("robots cannot be drawn here" in output.get("text", "") for output in told)
    if path.stem == "own_effect":
        [last] = book.cells[-1]["outputs"]
        assert "a brake at shaft resists most" in last["text"]
