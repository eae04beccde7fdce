"""Rows come back from Parquet as they were written, whatever JSON they hold."""

import math
from pathlib import Path

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from experiments.harness.rows import read_about, read_rows, write_rows

_SCALARS = st.none() | st.booleans() | st.integers(-(2**70), 2**70) | st.floats(allow_nan=False) | st.text(max_size=3)
_VALUES = st.recursive(
    _SCALARS, lambda v: st.lists(v, max_size=3) | st.dictionaries(st.sampled_from("abc"), v, max_size=2), max_leaves=6
)
_ROWS = st.lists(st.fixed_dictionaries({"case": st.text(max_size=3), "x": _VALUES, "y": _VALUES}), max_size=4)


@settings(max_examples=20, suppress_health_check=[HealthCheck.function_scoped_fixture], derandomize=True)
@given(_ROWS)
def test_any_rows_come_back(tmp_path: Path, rows: list[dict]) -> None:
    write_rows(tmp_path / "rows.parquet", rows, seed=3)
    found = read_rows(tmp_path / "rows.parquet")
    assert [{k: repr(v) for k, v in row.items()} for row in found] == [{k: repr(v) for k, v in r.items()} for r in rows]


def test_what_rows_were_got_with_comes_back_and_a_missing_column_is_none(tmp_path: Path) -> None:
    path = tmp_path / "rows.parquet"
    write_rows(path, [{"robot": "same", "right": True}, {"robot": "foreign", "errors": {"nominal": 0.1}}], seed=20261)
    assert read_about(path) == {"seed": 20261}
    assert read_rows(path)[0] == {"robot": "same", "right": True, "errors": None}
    assert math.isclose(read_rows(path)[1]["errors"]["nominal"], 0.1)


def test_without_a_file_there_are_no_rows(tmp_path: Path) -> None:
    assert read_rows(tmp_path / "none.parquet") == [] and read_about(tmp_path / "none.parquet") == {}
