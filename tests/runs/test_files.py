"""Results as JSON, and files that are whole or not there."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from estexp_jax.runs import write_json
from estexp_jax.runs.files import json_plain, replacing


@dataclass(frozen=True)
class Config:
    seed: int
    model: Path


def test_numbers_of_all_kinds_become_plain(tmp_path):
    value = {
        "nan": float("nan"),
        "numpy": [np.float32(0.5), np.int64(3), np.bool_(True), np.float64(np.inf)],
        "array": np.array([[1.0, np.nan], [-np.inf, 2.0]]),
        "config": Config(1, Path("a/b.xml")),
        "tuple": (1, None, "ä"),
        3: True,
        "big": 2**70,
    }
    write_json(tmp_path / "a.json", value)
    text = (tmp_path / "a.json").read_text(encoding="utf-8")
    assert json.loads(text, parse_constant=lambda name: pytest.fail(name)) == {
        "nan": None,
        "numpy": [0.5, 3, True, None],
        "array": [[1.0, None], [None, 2.0]],
        "config": {"seed": 1, "model": "a/b.xml"},
        "tuple": [1, None, "ä"],
        "3": True,
        "big": 2**70,
    }
    assert "ä" in text and text.endswith("}\n")
    assert [path.name for path in tmp_path.iterdir()] == ["a.json"]


def test_what_has_no_json_form_is_told_with_its_place(tmp_path):
    with pytest.raises(TypeError, match=r"value\.a\[1\] is a set"):
        write_json(tmp_path / "a.json", {"a": [1, {2}]})
    with pytest.raises(TypeError, match="keys are texts"):
        json_plain({(1, 2): 3})
    assert list(tmp_path.iterdir()) == []


def test_an_error_while_writing_leaves_the_old_file(tmp_path):
    path = tmp_path / "a"
    path.write_text("old")
    with pytest.raises(RuntimeError), replacing(path) as stream:
        stream.write(b"half")
        assert path.read_text() == "old"
        raise RuntimeError
    assert path.read_text() == "old" and len(list(tmp_path.iterdir())) == 1
