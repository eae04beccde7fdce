"""Results of `explain` that somebody damaged, or put something else in the place of."""

import json

import pytest

import estexp_jax as ee
from estexp_jax.errors import InputError
from estexp_jax.report.explain.files import EFFECTS_SCHEMA
from estexp_jax.report.read_results import read_results

ARM = """<mujoco><worldbody><body><joint name="elbow" axis="0 1 0"/><geom size=".1"/></body></worldbody>
<actuator><position joint="elbow"/></actuator><sensor><jointpos joint="elbow"/></sensor></mujoco>"""
FRICTION = {"effect": "coulomb_friction", "kind": "joint", "name": "elbow", "parameters": {"T": 0.3}}
GOOD = {"schema": EFFECTS_SCHEMA, "nominal": "nominal.xml", "finer": 4, "changes": [FRICTION]}


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "nominal.xml").write_text(ARM)
    (tmp_path / "effects.json").write_text(json.dumps(GOOD))
    return tmp_path


def test_what_is_whole_comes_back(folder):
    simulator = ee.load_explained(folder)
    assert simulator.finer == 4 and simulator.changes[0].place == "coulomb_friction@elbow"


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"finer": "x"}, "damaged"),
        ({"finer": 0}, "damaged"),
        ({"changes": 3}, "damaged"),
        ({"changes": [{}]}, "damaged.*name"),
        ({"changes": [FRICTION | {"parameters": {"T": "much"}}]}, "damaged.*T is no number"),
        ({"changes": [FRICTION | {"parameters": {"T": 1e301}}]}, "damaged"),
        ({"changes": [FRICTION | {"name": ["elbow"]}]}, "damaged"),
        ({"changes": [FRICTION | {"name": "wrist"}]}, "wrist"),
        ({"changes": [FRICTION | {"effect": "magic"}]}, "magic"),
        ({"nominal": 5}, "damaged"),
        ({"nominal": "../../etc/passwd"}, "no such|does not compile|well-formed"),
        ({"schema": "estexp.findings/1"}, "its schema is estexp.effects/1"),
    ],
)
def test_what_says_something_else_is_told(folder, change, told):
    (folder / "effects.json").write_text(json.dumps(GOOD | change))
    with pytest.raises(InputError, match=told):
        ee.load_explained(folder)


@pytest.mark.parametrize("target", ["/dev/zero", "effects.json", "nowhere", "..", "nominal.xml"])
def test_links_in_its_place_are_told_and_never_read_for_ever(folder, target):
    (folder / "effects.json").unlink()
    (folder / "effects.json").symlink_to(target)
    with pytest.raises(InputError, match="effects.json: cannot be read"):
        ee.load_explained(folder)


def test_what_is_nested_without_end_or_far_too_long_is_told(folder, monkeypatch):
    path = folder / "effects.json"
    path.write_text("[" * 100_000)
    with pytest.raises(InputError, match="cannot be read"):
        read_results(path, EFFECTS_SCHEMA, "a list")
    monkeypatch.setattr("estexp_jax.report.read_results._MOST_BYTES", 10)
    with pytest.raises(InputError, match="bytes long"):
        read_results(path, EFFECTS_SCHEMA, "a list")
