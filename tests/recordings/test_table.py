"""Columns of a table by name and index."""

import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.recordings.readers.read import read_table


def test_missing_column_lists_what_exists_and_index_must_fit(tmp_path):
    path = tmp_path / "a.npz"
    np.savez(path, time=np.arange(2), x=np.ones((2, 3)))
    table = read_table(path)
    with pytest.raises(InputError, match=r"a\.npz: no column 'y'; known are: time, x"):
        table.column("y")
    with pytest.raises(InputError, match="column 'x': has 3 values a row, none at index 3"):
        table.column("x", 3)
    with pytest.raises(InputError, match="column 'x': has 3 values a row"):
        table.column("x")
    with pytest.raises(InputError, match="column 'time': has one value a row"):
        table.column("time", 0)
