"""Outside the folder of effects no module knows an effect by its name: what is special about one, it says itself."""

import ast
from pathlib import Path

import mujoco
import pytest

from estexp_jax.physics.effects.registry import every
from tests.conftest import ROOT

PACKAGE = ROOT / "estexp_jax"
EFFECTS = PACKAGE / "physics" / "effects"
NAMES = frozenset(e.name for e in every())
MODEL_FIELDS = frozenset(name for name in NAMES if hasattr(mujoco.MjModel, name))
"""Names that are also fields of MuJoCo's model, and stand for these where models are simulated."""
SIMULATION = tuple(PACKAGE / folder for folder in ("lanes", "physics/engines", "physics/model"))


def named(path: Path, source: str) -> list[str]:
    """`file:line 'name'` of each string literal in a module that equals an effect's name; docstrings aside."""
    tree = ast.parse(source)
    bare = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    names = NAMES - MODEL_FIELDS if any(folder in path.parents for folder in SIMULATION) else NAMES
    return [
        f"{path}:{node.lineno} '{node.value}'"
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant) and node.value in names and id(node) not in bare
    ]


def test_no_module_outside_the_effects_names_one() -> None:
    modules = [path for path in sorted(PACKAGE.rglob("*.py")) if EFFECTS not in path.parents]
    assert len(modules) > 100
    assert [hit for path in modules for hit in named(path, path.read_text(encoding="utf-8"))] == []


@pytest.mark.parametrize(
    ("folder", "line", "hits"),
    [
        ("discovery", 'if name == "cogging": pass', 1),
        ("recovery", 'SPECIAL = {"joint_jam": 1, "law_sag": 2}', 2),
        ("discovery", 'mass = values["body_mass"]', 1),
        ("lanes", 'mass = numbers.get("body_mass")', 0),
        ("lanes", 'lost = values["part_lost"]', 1),
        ("discovery", '"cogging"', 0),
        ("discovery", 'message = "the cogging of a motor"', 0),
    ],
)
def test_a_name_is_noticed_where_it_decides(folder: str, line: str, hits: int) -> None:
    assert len(named(PACKAGE / folder / "new.py", line)) == hits
