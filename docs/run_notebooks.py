"""Runs the notebooks and keeps their outputs in them: `python docs/run_notebooks.py [NAME ...]`; takes some minutes."""

import sys
import tempfile
from pathlib import Path

import nbformat
from nbclient import NotebookClient

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "experiments" / "notebooks"
_MOST = 200_000
"""Characters of an output that is kept: films are left out, so that the repository stays small."""


def main(names: list[str]) -> None:
    """Run those, or all."""
    for path in sorted(FOLDER.glob("*.ipynb")):
        if names and path.stem not in names:
            continue
        book = nbformat.read(path, as_version=4)
        with tempfile.TemporaryDirectory() as folder:
            NotebookClient(book, timeout=1800, record_timing=False, resources={"metadata": {"path": folder}}).execute()
        book.metadata.pop("widgets", None)
        for cell in book.cells:
            kept = [o for o in cell.get("outputs", []) if len(o.get("data", {}).get("text/html", "")) <= _MOST]
            cell.update({"outputs": kept} if cell.cell_type == "code" else {})
        path.write_text(nbformat.writes(book).replace(f"{ROOT}/", "") + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
