"""Parquet logs: numbers, nulls, lists and text."""

import numpy as np
import pyarrow
import pytest
from pyarrow import parquet

from estexp_jax.errors import InputError
from estexp_jax.recordings.readers.read import read_table


def test_parquet_numbers_nulls_lists_and_text(tmp_path):
    path = tmp_path / "a.parquet"
    columns = {
        "time": [0, 1],
        "x": [1.0, None],
        "on": [True, False],
        "state": [[1.0, 2.0], [3.0, None]],
        "ragged": [[1.0], [1.0, 2.0]],
        "word": ["a", "b"],
        "words": [["a"], ["b"]],
    }
    parquet.write_table(pyarrow.table(columns), path)
    table = read_table(path)
    np.testing.assert_array_equal(table.column("time"), [0.0, 1.0])
    np.testing.assert_array_equal(table.column("x"), [1.0, np.nan])
    np.testing.assert_array_equal(table.column("on"), [1.0, 0.0])
    np.testing.assert_array_equal(table.column("state", 1), [2.0, np.nan])
    for name in ("ragged", "word", "words"):
        with pytest.raises(InputError, match=rf"a\.parquet, column '{name}'"):
            table.column(name)
