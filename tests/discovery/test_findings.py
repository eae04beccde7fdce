"""Findings of real explanations are what the schema says; the schema refuses what is not."""

import copy
import json

import numpy as np
import pytest
from jsonschema import Draft202012Validator

from estexp_jax.package_data import schema_path
from estexp_jax.physics.effects.registry import named_effects
from estexp_jax.runs import versions, write_json


@pytest.fixture(scope="module")
def validator():
    schema = json.loads(schema_path("findings").read_text(encoding="utf-8"))
    Draft202012Validator.check_schema(schema)
    return Draft202012Validator(schema)


def written(findings, path) -> dict:
    """As it comes back from `findings.json`."""
    write_json(
        path, {**findings, "cost": {**findings["cost"], "wall_s": 1.5, "compile_s": np.nan}, "versions": versions()}
    )
    return json.loads(path.read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", ["coulomb_friction@shaft", "nothing"])
def test_findings_follow_the_schema(name, diagnosed, validator, tmp_path):
    found = written(diagnosed(name).findings, tmp_path / "findings.json")
    validator.validate(found)
    assert found["cost"]["compile_s"] is None
    assert [d["role"] for d in found["data"]] == ["train"] * 3 + ["test"]
    shares = [w["share"] for w in found["where"]]
    assert shares == sorted(shares, reverse=True)
    assert sum(shares) == pytest.approx(1.0, abs=0.1) if name != "nothing" else not shares


WRONG = {
    "verdict": lambda f: f.update(verdict="broken"),
    "side": lambda f: f.update(side="left"),
    "schema": lambda f: f.update(schema="estexp.findings/2"),
    "a key too much": lambda f: f.update(more=1),
    "a key too few": lambda f: f.pop("seed"),
    "effect": lambda f: f["what"][0].update(effect="magic"),
    "kind": lambda f: f["where"][0].update(kind="leg"),
    "probability": lambda f: f["what"][0].update(probability=1.2),
    "alternative": lambda f: f["alternatives"][0].update(effects=["magic@shaft"]),
    "text for a number": lambda f: f["fit"]["nominal"].update(test="0.1"),
    "half a rival": lambda f: f["fit"].update(black_box={"train": 0.1}),
    "role": lambda f: f["data"][0].update(role="both"),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_the_schema_refuses_what_the_specification_does(wrong, diagnosed, validator, tmp_path):
    found = written(diagnosed("coulomb_friction@shaft").findings, tmp_path / "findings.json")
    validator.validate(found)
    WRONG[wrong](found)
    assert not validator.is_valid(found)


def test_empty_and_whole_rivals_and_free_runs_are_allowed(diagnosed, validator, tmp_path):
    found = written(diagnosed("coulomb_friction@shaft").findings, tmp_path / "findings.json")
    other = copy.deepcopy(found)
    other["fit"].update(black_box={"train": 0.1, "test": None}, window_s=None)
    other["fit"]["gain"] = {"value": None, "low": None, "high": None}
    other.update(verdict="unexplained", side=None, what=[], where=[])
    assert list(validator.iter_errors(other)) == []


def test_every_effect_of_the_catalogue_has_its_name_in_the_schema(validator):
    definitions = validator.schema["$defs"]
    assert {e.name for e in named_effects()} <= set(definitions["effect"]["enum"])
    assert {e.kind for e in named_effects()} <= set(definitions["kind"]["enum"])
    assert {e.side for e in named_effects()} <= set(validator.schema["properties"]["side"]["enum"])
