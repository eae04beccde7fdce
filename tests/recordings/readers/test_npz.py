"""NumPy archives: columns, lists, and members that are not columns."""

import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.recordings.readers.read import read_table


def test_npz_columns_lists_and_what_is_no_column(tmp_path):
    path = tmp_path / "a.npz"
    np.savez(
        path, time=np.arange(3), x=np.ones((3, 2), np.float32), name=np.array(["a", "b", "c"]), cube=np.ones((3, 1, 1))
    )
    table = read_table(path)
    assert table.column("time").dtype == np.float64
    np.testing.assert_array_equal(table.column("x", 1), np.ones(3))
    for name in ("name", "cube"):
        with pytest.raises(InputError, match=rf"a\.npz, column '{name}'"):
            table.column(name)


def test_npz_with_pickled_objects_is_refused(tmp_path):
    path = tmp_path / "a.npz"
    np.savez(path, time=np.arange(2), x=np.array([{}, None], dtype=object))
    with pytest.raises(InputError, match="column 'x'"):
        read_table(path).column("x")


def test_npy_under_the_name_of_an_archive(tmp_path):
    with (tmp_path / "a.npz").open("wb") as stream:
        np.save(stream, np.arange(3))
    with pytest.raises(InputError, match=r"a\.npz: is not a NumPy \.npz archive"):
        read_table(tmp_path / "a.npz")
