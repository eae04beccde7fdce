"""The rules of the house that no linter knows: names, sizes, no import circle."""

import ast
import io
import tokenize
from collections import Counter
from collections.abc import Iterator
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path
from statistics import median

from tests.conftest import ROOT

PACKAGE = ROOT / "estexp_jax"
OLD_SEARCH = "discovery"
"""Its inside is being replaced; the exception goes with it."""

RETIRED = frozenset(
    """
    Problem Segment Start starts RUNGS doubt slack about heard loudness slopes walks Free Member rounds growing
    looked_at Standing Setting hangs_on_hairs late begun dating beginnings believing crowded doubled manifold nearly
    piled likely_laws likely_waves force_residual telling shown contest rivals rehearsal separating apart touching
    holding gaps commanded soundness description schedule JointMoment moment seats pulls rubs stops plan numbers
    support Walker walker Walk walk Replayer replayer foreign evidence reproduction mismatch most_telling foretold
    Beat beat Crew crew handed doubts unnamed kills concealed bent stretched unbent Recorded told tells seen hear
    """.split()
)
"""Words of a private dialect, each with a standard term in its place."""


def modules() -> list[Path]:
    return sorted(PACKAGE.rglob("*.py"))


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def dotted(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def identifiers(path: Path) -> Iterator[tuple[int, str]]:
    """Names in a module with their lines; not those of dotted paths into the search that is being replaced."""
    for token in tokenize.generate_tokens(io.StringIO(path.read_text(encoding="utf-8")).readline):
        if token.type == tokenize.NAME and f".{OLD_SEARCH}" not in token.line:
            yield token.start[0], token.string


def test_no_retired_word_is_an_identifier():
    found = [
        f"{path.relative_to(ROOT)}:{line}: {name}"
        for path in modules()
        if path.relative_to(PACKAGE).parts[0] != OLD_SEARCH
        for line, name in identifiers(path)
        if name.strip("_") in RETIRED
    ]
    assert not found, f"{len(found)}, such as {found[:40]}"


def test_a_public_class_or_function_exists_once():
    owners = {
        (node.name, path)
        for path in modules()
        if path.relative_to(PACKAGE).parts[0] != OLD_SEARCH
        for node in tree(path).body
        if isinstance(node, ast.ClassDef | ast.FunctionDef) and not node.name.startswith("_")
    }
    names = Counter(name for name, _ in owners)
    assert not {name for name, count in names.items() if count > 1}


def test_modules_are_small():
    lengths = {path: len(path.read_text(encoding="utf-8").splitlines()) for path in modules()}
    assert not [f"{path.relative_to(ROOT)}: {n}" for path, n in lengths.items() if n > 250]
    assert median(n for path, n in lengths.items() if path.name != "__init__.py") <= 110


def test_no_import_circle():
    """Of modules, by the imports that run when a module is loaded; an import inside a function is none of these."""
    known, graph = {dotted(path) for path in modules()}, {}
    for path in modules():
        wanted = set()
        for node in tree(path).body:
            if isinstance(node, ast.ImportFrom) and node.module:
                names = {f"{node.module}.{alias.name}" for alias in node.names}
                wanted |= (names & known) | ({node.module} & known if names - known else set())
            elif isinstance(node, ast.Import):
                wanted |= {alias.name for alias in node.names} & known
        graph[dotted(path)] = wanted - {dotted(path)}
    order = list(TopologicalSorter(graph).static_order())  # raises CycleError
    assert set(order) == known
