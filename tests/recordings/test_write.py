"""What is written comes back, bit for bit."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from estexp_jax.recordings.readers.read import read_table
from estexp_jax.recordings.write import write_csv

# A lone column with a semicolon in its name is taken for a file with another separator.
_names = st.text(st.characters(codec="utf-8", exclude_categories=("C", "Z"), exclude_characters=";"), min_size=1)


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_round_trip(tmp_path, data):
    rows = data.draw(st.integers(0, 6))
    values = st.lists(st.floats(), min_size=rows, max_size=rows).map(lambda v: np.array(v, dtype=np.float64))
    columns = data.draw(st.dictionaries(_names.map(lambda name: f"c{name}"), values, min_size=1, max_size=4))
    write_csv(tmp_path / "a.csv", columns)
    table = read_table(tmp_path / "a.csv")
    assert table.names == tuple(columns)
    for name, written in columns.items():
        read = table.column(name)
        np.testing.assert_array_equal(read, written)
        np.testing.assert_array_equal(np.signbit(read[~np.isnan(read)]), np.signbit(written[~np.isnan(written)]))


def test_nan_is_an_empty_cell_and_integers_stay_integers(tmp_path):
    write_csv(tmp_path / "a.csv", {"t": np.array([0.1, np.nan]), "n": np.arange(2), "b": np.array([True, False])})
    assert (tmp_path / "a.csv").read_text() == "t,n,b\n0.1,0,1\n,1,0\n"


def test_a_failed_write_leaves_the_old_file_and_no_draft(tmp_path):
    path = tmp_path / "a.csv"
    write_csv(path, {"t": np.array([1.0])})
    with pytest.raises(TypeError):
        write_csv(path, {"t": np.array(["text"])})
    assert path.read_text() == "t\n1.0\n"
    assert [p.name for p in tmp_path.iterdir()] == ["a.csv"]


def test_columns_of_different_length_are_refused(tmp_path):
    with pytest.raises(ValueError, match="one length"):
        write_csv(tmp_path / "a.csv", {"a": np.zeros(2), "b": np.zeros(3)})
